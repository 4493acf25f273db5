"""A real camera and a printed marker: pictures by tracing the true lens' rays, and what the robot says."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from services.task.geometry import Pose
from services.task.vision.detection import DICTIONARY
from shared.spatial import Array

Grey = NDArray[np.uint8]

_MODULES, _MARGIN = 6, 1  # of the square, and of white around it
_TEXELS = 40  # [px] of the print's picture per module
_GRID = 4  # [px] between two rays that are traced; between them the texture's coordinates are linear to 0.01 px
_FINER = 2  # rays per pixel and direction
_GROUND, _PAPER, _INK = 120.0, 220.0, 25.0  # [of 255]


def _no_lens() -> Array:
    return np.zeros(5)


@dataclass
class Lens:
    """A calibration.

    Attributes:
        size: width and height [px].
        intrinsics: fx, fy, cx, cy [px].
        distortion: 0, 4, 5 or 8 coefficients in OpenCV's order, or four of a fisheye.
        fisheye: whether they are those of OpenCV's fisheye (equidistant).
    """

    size: tuple[int, int]
    intrinsics: Array
    distortion: Array = field(default_factory=_no_lens)
    fisheye: bool = False

    @property
    def matrix(self) -> Array:
        """Camera matrix (3, 3)."""
        fx, fy, cx, cy = self.intrinsics
        return np.array(((fx, 0.0, cx), (0.0, fy, cy), (0.0, 0.0, 1.0)))

    def seen(self, points: Array) -> Array:
        """Pixels (n, 2) of points (n, 3) [m] in the optical frame."""
        still = np.zeros((3, 1))
        if self.fisheye:
            found, _ = cv2.fisheye.projectPoints(points.reshape(-1, 1, 3), still, still, self.matrix, self.distortion)
        else:
            found, _ = cv2.projectPoints(points, still, still, self.matrix, self.distortion)
        return found.reshape(-1, 2)

    def rays(self, pixels: Array) -> Array:
        """Directions (n, 3) with z = 1 of pixels (n, 2)."""
        flat = pixels.reshape(-1, 1, 2)
        if self.fisheye:
            found = cv2.fisheye.undistortPoints(flat, self.matrix, self.distortion)
        else:
            enough = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 40, 1e-9)
            found = cv2.undistortPointsIter(flat, self.matrix, self.distortion, None, None, enough)
        return np.column_stack((found.reshape(-1, 2), np.ones(len(pixels))))


@dataclass
class Light:
    """Blur [px], noise [of 255], brightness [1]."""

    blur: float = 0.6
    noise: float = 2.0
    level: float = 1.0


def picture(lens: Lens, marker: Pose, size: float, number: int, light: Light, random: np.random.Generator) -> Grey:
    """What the camera sees (height, width).

    Args:
        lens: the true one.
        marker: in the optical frame.
        size: side [m] of the black square.
        number: of the marker.
        light: what it is seen in.
        random: of the noise.
    """
    width, height = lens.size
    image = np.full((height, width), _GROUND, np.float32)
    half = size / 2 * (1 + 2 * _MARGIN / _MODULES)
    rim = np.linspace(-half, half, 5)
    edge = np.array([(x, y, 0.0) for x in rim for y in rim]) @ marker.rotation.T + marker.position
    if edge[:, 2].min() > 0.05:
        seen = lens.seen(edge)
        low = np.maximum(np.floor(seen.min(axis=0)).astype(int) - 3, 0)
        high = np.minimum(np.ceil(seen.max(axis=0)).astype(int) + 4, (width, height))
        if (high - low > 4).all():
            part = image[low[1] : high[1], low[0] : high[0]]
            part[:] = _traced(lens, marker, half, _texture(number), low, high)
    image *= light.level
    if light.blur:
        image = cv2.GaussianBlur(image, (0, 0), light.blur)
    if light.noise:
        image += light.noise * _grain(width, height, random)
    return np.clip(np.round(image), 0, 255).astype(np.uint8)


def _traced(lens: Lens, marker: Pose, half: float, texture: Array, low: Array, high: Array) -> Array:
    """The brightness (height, width) of a rectangle of pixels that contains the marker."""
    xs, ys = (np.arange(low[axis] - 1, high[axis] + _GRID + 1, _GRID, dtype=float) for axis in (0, 1))
    pixels = np.stack(np.meshgrid(xs, ys), axis=-1).reshape(-1, 2)
    rays = lens.rays(pixels) @ marker.rotation
    eye = -marker.rotation.T @ marker.position
    across = eye[None, :2] - rays[:, :2] * (eye[2] / rays[:, 2:])
    texels = len(texture)
    # The texture's first row is the print's upper edge, the middle of its first texel is at 0.
    places = (np.stack((across[:, 0] + half, half - across[:, 1]), axis=1) / (2 * half) * texels - 0.5).astype(
        np.float32
    )
    coarse = places.reshape(len(ys), len(xs), 2)
    size = high - low
    fine_x, fine_y = (
        ((np.arange(size[axis] * _FINER) + 0.5) / _FINER - 0.5 + 1.0).astype(np.float32) / _GRID for axis in (0, 1)
    )
    grid = np.meshgrid(fine_x, fine_y)
    where = cv2.remap(coarse, *grid, cv2.INTER_LINEAR)
    fine = cv2.remap(texture, where, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=_GROUND)
    return cv2.resize(fine, (int(size[0]), int(size[1])), interpolation=cv2.INTER_AREA)


@lru_cache(maxsize=60)
def _texture(number: int) -> Array:
    square = cv2.aruco.generateImageMarker(cv2.aruco.getPredefinedDictionary(DICTIONARY), number, _MODULES * _TEXELS)
    margin = _MARGIN * _TEXELS
    texture = np.full((len(square) + 2 * margin,) * 2, _PAPER, np.float32)
    texture[margin:-margin, margin:-margin] = np.where(square > 127, _PAPER, _INK)
    return texture


@lru_cache(maxsize=8)
def _pool(width: int, height: int) -> Array:
    return np.random.default_rng(0).standard_normal((height + 97, width + 89), dtype=np.float32)


def _grain(width: int, height: int, random: np.random.Generator) -> Array:
    """Noise of a picture, cut from a larger one: to draw it anew takes longer than all the rest."""
    y, x = random.integers(97), random.integers(89)
    return _pool(width, height)[y : y + height, x : x + width]


def encoded(image: Grey, encoding: str) -> bytes:
    """A grey picture as the robot sends it."""
    if encoding in ("jpeg", "png"):
        settings: list[Any] = [cv2.IMWRITE_JPEG_QUALITY, 95] if encoding == "jpeg" else [cv2.IMWRITE_PNG_COMPRESSION, 1]
        return cv2.imencode(f".{encoding[:3]}" if encoding == "png" else ".jpg", image, settings)[1].tobytes()
    return (image if encoding == "mono8" else np.repeat(image[:, :, None], 3, axis=2)).tobytes()
