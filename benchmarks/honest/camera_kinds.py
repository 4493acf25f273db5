"""The kinds of cameras that are drawn: sound ones, and what goes wrong with real ones."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import cv2
import numpy as np

from benchmarks.honest.camera_trial import Case
from benchmarks.honest.optics import Lens, Light
from services.task.geometry import Pose
from shared.spatial import Array, rotation_from_vector

Random = np.random.Generator

MARKER = Pose.from_rpy((0.85, -0.3, 0.825), (0.0, 0.0, -math.pi / 2))  # on a panel on its supports
SIZES = ((640, 480), (640, 480), (640, 480), (800, 600), (1280, 720))  # [px] docs/task.md asks for the first at least
MIRRORED = (8, 9, 17, 47)  # of DICT_4X4_50 read the same in a mirrored picture
ONE_PLACE = "all views are off alike, whichever way the head turns: only something else than the camera could show it"


def lens(
    random: Random, coefficients: int | None = None, strength: float = 1.0, size: tuple[int, int] | None = None
) -> Lens:
    """One that opens 55 to 75 degrees, with a distortion of so many coefficients as lenses have it."""
    width, height = size or SIZES[random.integers(len(SIZES))]
    focal = width / 2 / math.tan(math.radians(random.uniform(55.0, 75.0)) / 2)
    centre = np.array((width, height)) * (0.5 + random.uniform(-0.03, 0.03, 2))
    count = int(random.choice((0, 4, 5, 8))) if coefficients is None else coefficients
    typical = np.array(
        (random.uniform(-0.3, 0.1), random.uniform(-0.05, 0.15), *random.uniform(-2e-3, 2e-3, 2), 0, 0, 0, 0)
    )
    if count >= 5:
        typical[4] = random.uniform(-0.05, 0.05)
    if count == 8:
        # As the rational model is found for a time-of-flight camera: most of it cancels out, if all of it is there.
        typical[5:] = random.uniform(0.2, 0.6), random.uniform(-2.6, -1.0), random.uniform(0.8, 1.6)
        typical[[0, 1, 4]] = 0.5 * typical[[0, 1, 4]] + typical[5:]
    focals = (focal, focal * random.uniform(0.99, 1.01))
    return Lens((width, height), np.array((*focals, *centre)), typical[:count] * (strength if count < 8 else 1.0))


def sound(random: Random, coefficients: int | None = None, strength: float = 1.0) -> Case:
    """One that is as the robot process states it, and a panel in front of the robot."""
    true = lens(random, coefficients, strength)
    away = random.uniform((-0.05, -0.08, 0.0), (0.05, 0.08, 0.0))
    lying = rotation_from_vector((*random.uniform(-0.03, 0.03, 2), random.uniform(-0.25, 0.25)))
    light = Light(random.uniform(0.4, 1.0), random.uniform(1.0, 4.0), random.uniform(0.5, 1.1))
    torso = random.uniform(0.15, 0.3)
    return Case(true, true, marker=Pose(MARKER.position + away, lying @ MARKER.rotation), light=light, torso=torso)


def plain(random: Random) -> Case:
    case = sound(random)
    case.encoding = str(random.choice(("jpeg", "rgb8", "bgr8", "mono8", "png")))
    return case


def noise_free(random: Random) -> Case:
    """A renderer's pictures: two of one view are the same to the last byte."""
    case = sound(random)
    case.light.noise, case.encoding = 0.0, str(random.choice(("png", "mono8")))
    return case


def rectified(random: Random) -> Case:
    """A rectified picture with its own calibration."""
    return sound(random, 0)


def small(random: Random) -> Case:
    """A picture of a quarter of the pixels that are asked for: as it is stated, yet the corners are vague."""
    true = lens(random, size=(320, 240))
    return replace(sound(random), true=true, told=true, sound=False)


def centre_off(random: Random) -> Case:
    case = sound(random)
    away = random.uniform(15.0, 60.0) * case.true.size[0] / 640
    angle = random.uniform(-math.pi, math.pi)
    return _told(case, intrinsics=case.true.intrinsics + away * np.array((0.0, 0.0, math.cos(angle), math.sin(angle))))


def focal_off(random: Random) -> Case:
    """A focal length of another lens, one of its two, or that of another resolution."""
    case = sound(random)
    off = random.choice((-1.0, 1.0)) * random.uniform(0.05, 0.25)
    which = random.choice(("both", "one", "resolution"))
    factor = np.array({"both": (1 + off, 1 + off, 1, 1), "one": (1 + off, 1, 1, 1), "resolution": (2, 2, 2, 2)}[which])
    if which == "resolution" and random.random() < 0.5:
        factor = 1.0 / factor
    return _told(case, intrinsics=case.true.intrinsics * factor)


def distortion_cut(random: Random) -> Case:
    """Eight coefficients, of which the first five or four are sent."""
    case = sound(random, 8)
    return _told(case, distortion=case.true.distortion[: random.choice((4, 5))])


def distortion_wrong(random: Random) -> Case:
    """Left out, of the other sign, applied to a rectified picture, or in another order."""
    strength = random.uniform(0.7, 1.5)
    which = random.choice(("left out", "sign", "rectified", "order"))
    if which == "rectified":
        case = sound(random, 0)
        return _told(case, distortion=lens(random, 5, strength).distortion)
    case = sound(random, 5, strength)
    found = case.true.distortion
    wrong = {"left out": np.zeros(0), "sign": -found, "order": found[[0, 1, 4, 2, 3]]}[which]
    return _told(case, distortion=wrong)


def fisheye(random: Random) -> Case:
    """A wide lens whose four coefficients are sent as if they were a plain one's; its model told, or not."""
    case = sound(random, 0)
    width, height = case.true.size
    focal = width / random.uniform(1.6, 2.2)
    true = Lens((width, height), np.array((focal, focal, width / 2, height / 2)), random.uniform(-0.05, 0.05, 4), True)
    case.true = true
    case.model = str(random.choice(("", "equidistant")))
    distortion = true.distortion if random.random() < 0.5 else np.zeros(4)
    return replace(case, told=Lens(true.size, true.intrinsics, distortion), sound=False)


def mounted(random: Random) -> Case:
    """The camera is turned or shifted on the head: where the robot process states is not where it is."""
    case = sound(random)
    case.sound = False
    if random.random() < 0.6:
        axis = random.standard_normal(3)
        turn = axis / np.linalg.norm(axis) * math.radians(random.choice((2.0, 4.0, 8.0, 90.0, 180.0)))
        return replace(case, mount=Pose(np.zeros(3), rotation_from_vector(turn)))
    away = random.standard_normal(3)
    away *= random.uniform(0.015, 0.06) / np.linalg.norm(away)
    return replace(case, mount=Pose(away, np.eye(3)))


def head_lifted(random: Random) -> Case:
    """The torso is higher or lower than the robot process states."""
    return replace(
        sound(random), lifted=random.choice((-1.0, 1.0)) * random.uniform(0.015, 0.08), sound=False, excuse=ONE_PLACE
    )


def size_wrong(random: Random) -> Case:
    """A marker printed larger or smaller than declared."""
    return replace(sound(random), size=0.15 * random.choice((0.5, 0.8, 0.93, 0.96, 1.04, 1.07, 1.33)), sound=False)


def mirrored(random: Random) -> Case:
    """The picture is mirrored or upside down; the number reads the same, or not."""
    case = sound(random)
    case.number = int(random.choice((7, *MIRRORED)))
    case.declared = {"marker_id": case.number}
    axis = int(random.choice((0, 1, -1)))

    def edit(image: Any) -> Any:
        return np.ascontiguousarray(cv2.flip(image, axis))

    return replace(case, edit=edit, sound=False)


def frozen(random: Random) -> Case:
    """The picture stays the same from some moment on, under fresh stamps and poses."""
    return replace(sound(random), freezes=random.uniform(0.0, 4.0), sound=False)


def scaled(random: Random) -> Case:
    """The picture is scaled or cropped after the calibration was made."""
    case = sound(random)
    width, height = case.true.size
    if random.random() < 0.5:
        factor = random.choice((0.5, 0.75, 1.5))
        size = (round(width * factor), round(height * factor))
        return replace(case, edit=lambda image: cv2.resize(image, size, interpolation=cv2.INTER_AREA), sound=False)
    x, y = (int(random.uniform(0.04, 0.15) * side) for side in (width, height))
    return replace(case, edit=lambda image: np.ascontiguousarray(image[y:, x:]), sound=False)


def another(random: Random) -> Case:
    """A marker of another number."""
    return replace(sound(random), number=int(random.choice((3, 8, 17, 42))), sound=False)


def _told(case: Case, intrinsics: Array | None = None, distortion: Array | None = None) -> Case:
    told = case.told
    stated = Lens(
        told.size,
        told.intrinsics if intrinsics is None else intrinsics,
        told.distortion if distortion is None else distortion,
    )
    return replace(case, told=stated, sound=False)


KINDS: dict[str, tuple[float, Callable[[Random], Case]]] = {
    "sound camera": (10.0, plain),
    "camera without noise": (2.0, noise_free),
    "rectified picture": (2.0, rectified),
    "small picture": (2.0, small),
    "centre off": (4.0, centre_off),
    "focal length off": (4.0, focal_off),
    "distortion cut": (3.0, distortion_cut),
    "distortion wrong": (4.0, distortion_wrong),
    "fisheye": (2.0, fisheye),
    "camera mounted otherwise": (4.0, mounted),
    "head higher or lower": (2.0, head_lifted),
    "marker of another size": (3.0, size_wrong),
    "mirrored picture": (3.0, mirrored),
    "frozen picture": (2.0, frozen),
    "scaled or cropped picture": (2.0, scaled),
    "another number": (1.0, another),
}
"""Share of the draws and what draws one."""
