"""Images of a printed marker, rendered for the tests: perspective, blur, noise, uneven light, cover, other markers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np

from services.task.geometry import Pose
from services.task.vision.detection import DICTIONARY
from shared.messages import CameraImage
from shared.spatial import Array

WIDTH, HEIGHT = 640, 480
FOCAL = WIDTH / 2 / math.tan(math.radians(63.0) / 2)
INTRINSICS = np.array((FOCAL, FOCAL, WIDTH / 2 - 0.5, HEIGHT / 2 - 0.5))
_SUPERSAMPLING = 3
_MODULE_PIXELS = 60
_MODULES = 6
_MARGIN = 1
"""White border around the marker in modules."""


@dataclass
class Light:
    """How bright paper and ink are, what the light does across the image, and what the camera adds.

    Attributes:
        gradient: change of brightness [1] from the left to the right edge.
        blur: standard deviation [px].
        noise: standard deviation, of 255.
    """

    gradient: float = 0.0
    blur: float = 0.6
    noise: float = 2.0
    level: float = 1.0
    ink: float = 25.0
    paper: float = 220.0
    seed: int = 0


@dataclass
class Print:
    """A printed marker in the optical frame.

    Attributes:
        cover: share of its width that something dark hides, from the left.
        hidden: dark rectangles: left, upper, right and lower edge in modules from the square's upper left corner.
    """

    pose: Pose
    size: float = 0.1
    number: int = 7
    cover: float = 0.0
    hidden: Sequence[tuple[float, float, float, float]] = ()


@dataclass
class Camera:
    """The head camera; its pose in base."""

    pose: Pose = field(default_factory=lambda: Pose(np.zeros(3), np.eye(3)))
    distortion: Array = field(default_factory=lambda: np.zeros(5))


def tilted(
    distance: float, tilt: float, direction: float = 0.0, turn: float = 0.0, x: float = 0.0, y: float = 0.0
) -> Pose:
    """A marker in front of the camera: turned in its plane and tilted about an axis in that plane [rad]."""
    facing = np.diag((1.0, -1.0, -1.0))
    axis = np.array((math.cos(direction), math.sin(direction), 0.0))
    tilting = cv2.Rodrigues(tilt * axis)[0]
    turning = cv2.Rodrigues(np.array((0.0, 0.0, turn)))[0]
    return Pose(np.array((x, y, distance)), tilting @ facing @ turning)


def render(prints: Sequence[Print], light: Light | None = None, camera: Camera | None = None) -> Array:
    """Grey image (HEIGHT, WIDTH) of the prints."""
    light, camera = light or Light(), camera or Camera()
    scale = _SUPERSAMPLING
    picture = np.full((HEIGHT * scale, WIDTH * scale), 0.55 * light.paper, dtype=np.float32)
    for item in prints:
        texture, corners = _texture(item, light)
        seen, _ = cv2.projectPoints(
            corners, cv2.Rodrigues(item.pose.rotation)[0], item.pose.position, _matrix(), camera.distortion
        )
        target = ((seen.reshape(4, 2) + 0.5) * scale - 0.5).astype(np.float32)
        height, width = texture.shape
        source = np.array(((0, 0), (width, 0), (width, height), (0, height)), dtype=np.float32) - 0.5
        homography = cv2.getPerspectiveTransform(source, target)
        size = (WIDTH * scale, HEIGHT * scale)
        warped = cv2.warpPerspective(texture, homography, size, flags=cv2.INTER_LINEAR)
        mask = cv2.warpPerspective(np.ones_like(texture), homography, size, flags=cv2.INTER_LINEAR)
        picture = picture * (1 - mask) + warped
    image = cv2.resize(picture, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)
    image *= light.level * (1 + light.gradient * (np.arange(WIDTH) / WIDTH - 0.5))[None, :]
    if light.blur:
        image = cv2.GaussianBlur(image, (0, 0), light.blur)
    image += np.random.default_rng(light.seed).normal(0.0, light.noise, image.shape)
    return np.clip(np.round(image), 0, 255).astype(np.uint8)


def message(picture: Array, camera: Camera | None = None, encoding: str = "jpeg") -> CameraImage:
    """The picture as the robot sends it."""
    camera = camera or Camera()
    colour = np.repeat(picture[:, :, None], 3, axis=2)
    data = {
        "jpeg": lambda: cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 95])[1].tobytes(),
        "png": lambda: cv2.imencode(".png", picture)[1].tobytes(),
        "colour png": lambda: cv2.imencode(".png", colour)[1].tobytes(),
        "mono8": picture.tobytes,
    }.get(encoding, colour.tobytes)()
    encoding = encoding.removeprefix("colour ")
    return CameraImage(
        WIDTH, HEIGHT, encoding, data, INTRINSICS, camera.distortion, camera.pose.position, camera.pose.orientation
    )


def _texture(item: Print, light: Light) -> tuple[Array, Array]:
    """The print with its white border, and its corners (4, 3) [m] in marker axes from the upper left one on."""
    dictionary = cv2.aruco.getPredefinedDictionary(DICTIONARY)
    square = cv2.aruco.generateImageMarker(dictionary, item.number, _MODULES * _MODULE_PIXELS)
    margin = _MARGIN * _MODULE_PIXELS
    texture = np.full((square.shape[0] + 2 * margin,) * 2, 255, dtype=np.float32)
    texture[margin:-margin, margin:-margin] = square
    texture = light.ink + texture / 255 * (light.paper - light.ink)
    if item.cover:
        texture[:, : margin + round(item.cover * square.shape[1])] = 60.0
    for edges in item.hidden:
        left, upper, right, lower = (max(0, margin + round(edge * _MODULE_PIXELS)) for edge in edges)
        texture[upper:lower, left:right] = 45.0
    half = item.size / 2 * (1 + 2 * _MARGIN / _MODULES)
    corners = ((-half, half, 0.0), (half, half, 0.0), (half, -half, 0.0), (-half, -half, 0.0))
    return texture.astype(np.float32), np.array(corners)


def _matrix() -> Array:
    fx, fy, cx, cy = INTRINSICS
    return np.array(((fx, 0.0, cx), (0.0, fy, cy), (0.0, 0.0, 1.0)))
