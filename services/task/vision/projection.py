"""Where a square marker appears to a camera with a lens as OpenCV describes it, without OpenCV."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from services.task.geometry import Pose
from shared.spatial import Array, rotation_from_vector

SQUARE: Array = np.array(((-0.5, 0.5, 0.0), (0.5, 0.5, 0.0), (0.5, -0.5, 0.0), (-0.5, -0.5, 0.0)))
"""Corners (4, 3) of a marker of side 1 in its axes, in the order in which they are found: clockwise from upper left."""


@dataclass(frozen=True, eq=False)
class Calibration:
    """What is told about a camera and the marker that it sees.

    Attributes:
        intrinsics: fx, fy, cx, cy [px].
        distortion: up to eight coefficients in OpenCV's order.
        size: side [m] of the marker's square.
        turn: rotation vector (3,) [rad] from the optical frame as told to that as it is, in optical axes.
    """

    intrinsics: Array
    distortion: Array
    size: float
    turn: Array = field(default_factory=lambda: np.zeros(3))

    def same(self, other: Calibration) -> bool:
        """Whether intrinsics and distortion are those of another one."""
        return np.array_equal(self.intrinsics, other.intrinsics) and np.array_equal(self.distortion, other.distortion)


def projected(points: Array, intrinsics: Array, distortion: Array) -> Array:
    """Columns and rows (n, 2) [px] at which points (n, 3) [m] in optical axes appear."""
    fx, fy, cx, cy = intrinsics
    k1, k2, p1, p2, k3, k4, k5, k6 = np.pad(distortion, (0, 8 - len(distortion)))
    x, y = (points[:, :2] / points[:, 2:]).T
    r2 = x * x + y * y
    radial = (1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1.0 + r2 * (k4 + r2 * (k5 + r2 * k6)))
    across = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x)
    down = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y
    return np.stack((fx * across + cx, fy * down + cy), axis=1)


def corners_seen(marker: Pose, cameras: Sequence[Pose], told: Calibration) -> Array | None:
    """A marker's corners (n, 4, 2) [px] to cameras whose poses are told, all in one frame; None if behind one."""
    points = marker.position + told.size * SQUARE @ marker.rotation.T
    turn = rotation_from_vector(told.turn)
    inside = np.concatenate([(points - camera.position) @ (camera.rotation @ turn) for camera in cameras])
    if inside[:, 2].min() <= 0.0:
        return None
    return projected(inside, told.intrinsics, told.distortion).reshape(-1, 4, 2)
