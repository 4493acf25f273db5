"""What there is to see, and where it appears in the head camera's pictures."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from shared.spatial import Array

WIDTH, HEIGHT = 640, 480  # [px]
FIELD_OF_VIEW = math.radians(63.0)
"""[rad] Horizontal; it and the size are those of the camera in PAL Robotics' simulation of TIAGo (see NOTICE)."""
FOCAL_LENGTH = 0.5 * WIDTH / math.tan(0.5 * FIELD_OF_VIEW)  # [px]
INTRINSICS = (FOCAL_LENGTH, FOCAL_LENGTH, 0.5 * WIDTH, 0.5 * HEIGHT - 1.0)
"""[px] fx, fy, cx, cy; the middle of the first pixel is at (0, 0). The renderer looks at the lower left corner of each
pixel, not at its middle, as ``test_head_camera.py`` measures: cx and cy are not those of a real camera."""


@dataclass(frozen=True)
class View:
    """What there is to see at an instant, everything in base.

    Attributes:
        position, rotation: of the camera's optical frame (3,) [m], (3, 3).
        joints: positions of the robot's joints [m, rad] by name.
        panel, panel_rotation: of the panel's centre (3,) [m], (3, 3).
        supports: positions (2, 3) [m] of the trestles' upper edges and their heading [rad]; None: taken away.
        covered: whether something is over the marker.
        brighter: what is added to each pixel's values [of 255].
    """

    position: Array
    rotation: Array
    joints: Mapping[str, float]
    panel: Array
    panel_rotation: Array
    supports: tuple[Array, float] | None
    covered: bool
    brighter: float = 0.0


@dataclass(frozen=True)
class Scenery:
    """What does not change.

    Attributes:
        panel_size: (3,) [m].
        marker: its identity.
        marker_size: width [m] of its black square.
        marker_position: of its centre on the panel's upper face, in the panel's frame (2,) [m].
        light: 1 = normal, 0 = dark.
        noise: standard deviation of each pixel's values [of 255].
        seed: of the noise.
    """

    panel_size: tuple[float, float, float]
    marker: int
    marker_size: float
    marker_position: tuple[float, float]
    light: float
    noise: float = 0.0
    seed: int = 0

    @property
    def marker_in_panel(self) -> Array:
        """Centre (3,) [m] of the marker in the panel's frame."""
        return np.array((*self.marker_position, 0.5 * self.panel_size[2]))


def pixels(points: Array, position: Array, rotation: Array) -> Array:
    """Where points (n, 3) [m] appear to a camera at a position (3,) and rotation (3, 3), all in one frame.

    Returns:
        Column, row [px] and distance along the optical axis [m] of each (n, 3).
    """
    inside = (points - position).dot(rotation)
    depth = inside[:, 2:]
    fx, fy, cx, cy = INTRINSICS
    return np.hstack((inside[:, :2] / depth * (fx, fy) + (cx, cy), depth))
