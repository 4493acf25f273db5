"""What would explain poses that fit no payload: axes turned, signs, the wrong frame, a touch in one pose.

With every axis' mean taken away, forces f and directions d of gravity follow f = m Q d, Q = 1 if the sensor's axes are
those that `sensor/ft` states. With C = sum f d^T, the turn about z that fits best has the angle
atan2(C_yx - C_xy, C_xx + C_yy); rotation and mirror come from C's singular vectors (Kabsch). Whatever is suspected is
undone in the readings and fitted anew: it is named if it explains them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from services.wrench.averaging import AXES, UNITS, Average
from services.wrench.identification import IdentifiedPayload, NotExciting, identify, misfit
from shared.spatial import Array, rotation_from_vector, rotation_vector

_EQUAL = 1e-9  # [N, Nm] up to which means of one value differ by rounding
_FEWEST = 5  # poses: with fewer, one less explains whatever is left


def unexplained(result: IdentifiedPayload, poses: list[Average], tilt: float) -> str:
    """Why a payload does not explain the poses it was found from, with the likely causes; empty if it does.

    Args:
        result: of these poses.
        poses: that were identified.
        tilt: largest error of the attitude [rad].
    """
    shares = misfit(result, poses, tilt)
    if shares.max() <= 1.0:
        return ""
    what, unit, part = ("forces", "N", slice(0, 3)) if shares[0] >= shares[1] else ("torques", "Nm", slice(3, 6))
    left = _rms(result, part)
    return (
        f"the {what} of the {len(poses)} poses fit no payload: {left:.2g} {unit} are left (rms), noise and attitude "
        f"explain {left / math.sqrt(shares.max()):.2g} at most: {suspects(poses, tilt)}"
    )


def unmoved(poses: list[Average]) -> str:
    """Which axis read the same in every pose although others have noise, in words; empty if none did."""
    noisy = np.any([pose.std > _EQUAL for pose in poses], axis=0)
    same = np.ptp([pose.mean for pose in poses], axis=0) <= _EQUAL
    for axis in np.flatnonzero(same & ~noisy if noisy.any() else same & False):
        value = poses[0].mean[axis]
        return f"{AXES[axis]} was {value:g} {UNITS[axis]} in every pose, while other axes move: it feels nothing."
    return ""


def suspects(poses: list[Average], tilt: float) -> str:
    """What would explain readings that fit no payload, as a sentence; what is usual if nothing that is known does."""
    for words, mended in _mended(poses):
        try:
            found = identify(mended)
        except NotExciting:
            continue
        if misfit(found, mended, tilt).max() <= 1.0:
            return f"{words} would fit, rms {_rms(found, slice(0, 3)):.2g} N"
    return (
        "does something touch the tool, does a cable pull on it, are axes, signs, gains or units of the sensor wrong?"
    )


def _rms(result: IdentifiedPayload, part: slice) -> float:
    return math.sqrt(float((result.residual_rms[part] ** 2).mean()))


def _mended(poses: list[Average]) -> Iterator[tuple[str, list[Average]]]:
    """What may be wrong, in words, and the poses without it."""
    down = np.array([-pose.rotation[2] for pose in poses])
    forces = np.array([pose.mean[:3] for pose in poses])
    cross = (forces - forces.mean(axis=0)).T @ (down - down.mean(axis=0))
    yield "the opposite sign", [_turned(pose, -np.eye(3)) for pose in poses]
    yield "readings in base axes", [_turned(pose, pose.rotation) for pose in poses]
    angle = math.atan2(cross[1, 0] - cross[0, 1], cross[0, 0] + cross[1, 1])
    for more, sign in (("", 1.0), (" and of the opposite sign", -1.0)):
        turn = angle if sign > 0.0 else math.remainder(angle + math.pi, 2.0 * math.pi)
        about_z = rotation_from_vector((0.0, 0.0, turn))
        words = f"turned by {math.degrees(turn):.0f} degrees about z{more}"
        yield words, [_turned(pose, sign * about_z) for pose in poses]
    left, _, right = np.linalg.svd(cross)
    for sign in (1.0, -1.0):
        last = sign * float(np.linalg.det(left @ right))
        best = left @ np.diag((1.0, 1.0, last)) @ right
        yield _named(best), [_turned(pose, best) for pose in poses]
    if len(poses) >= _FEWEST:
        for number in range(len(poses)):
            yield f"a touch in pose {number + 1}: without it the rest", poses[:number] + poses[number + 1 :]


def _turned(pose: Average, axes: Array) -> Average:
    """A pose whose readings were given in ``axes`` @ the sensor's (3, 3), as if they had been given rightly."""
    return replace(pose, mean=np.concatenate((axes.T @ pose.mean[:3], axes.T @ pose.mean[3:])))


def _named(axes: Array) -> str:
    mirrored = float(np.linalg.det(axes)) < 0.0
    vector = rotation_vector(-axes if mirrored else axes)
    angle = float(np.linalg.norm(vector))
    along = ", ".join(f"{part:+.2f}" for part in vector / max(angle, 1e-9))
    words = f"turned by {math.degrees(angle):.0f} degrees about ({along})"
    return f"mirrored, and {words}" if mirrored else words
