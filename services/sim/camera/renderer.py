"""What the head's camera sees: robot, panel and marker, rendered on the processor."""

from __future__ import annotations

import math

import numpy as np
import pybullet

from services.sim.camera.canvas import Canvas, Picture
from services.sim.camera.panel_shapes import PanelShapes
from services.sim.camera.sight import FOCAL_LENGTH, HEIGHT, WIDTH, Look, Sight
from services.sim.scene.panel import SUPPORTS
from shared.spatial import rotation_from_vector

BACKGROUND = (184, 184, 178)
"""Colour of the floor and of everything else far away. To render a floor takes longer than all the rest."""
NEAR, FAR = 0.05, 8.0
LIGHT_FROM = (-1.0, -2.0, 4.0)
_BEAM = 0.03
"""Height [m] of a trestle's upper beam."""


class Renderer:
    """Poses the scene and renders it.

    Args:
        sight: what does not change.
    """

    def __init__(self, sight: Sight) -> None:
        self._sight = sight
        self._random = np.random.default_rng(sight.seed)
        self._canvas = Canvas(LIGHT_FROM, 0.6 * sight.light, 0.4 * sight.light, 0.0)
        size = (0.04, 0.8 * sight.panel_size[1], _BEAM)
        self._trestles = [self._canvas.box(size, (0.45, 0.36, 0.28, 1.0)) for _ in SUPPORTS]
        self._panel = PanelShapes(self._canvas, sight)
        self._projection = pybullet.computeProjectionMatrixFOV(
            math.degrees(2.0 * math.atan(0.5 * HEIGHT / FOCAL_LENGTH)), WIDTH / HEIGHT, NEAR, FAR
        )

    def picture(self, look: Look) -> Picture:
        """What the camera sees (height, width, 3): red, green, blue."""
        self._pose(look)
        forward, down = look.rotation[:, 2], look.rotation[:, 1]
        view = pybullet.computeViewMatrix(
            look.position.tolist(), (look.position + forward).tolist(), (-down).tolist()
        )
        picture, nothing = self._canvas.render(WIDTH, HEIGHT, view, self._projection)
        picture[nothing] = np.minimum(self._sight.light * np.array(BACKGROUND), 255.0).astype(np.uint8)
        if self._sight.noise == 0.0 and look.brighter == 0.0:
            return picture
        grain = self._sight.noise * self._random.standard_normal(picture.shape, dtype=np.float32)
        return np.clip(picture + (grain + np.float32(look.brighter)), 0.0, 255.0).astype(np.uint8)

    def _pose(self, look: Look) -> None:
        self._canvas.pose(look.joints)
        self._panel.pose(look.panel, look.panel_rotation, look.covered)
        for index, trestle in enumerate(self._trestles):
            if look.supports is None:
                self._canvas.hide(trestle)
            else:
                places, heading = look.supports
                turned = rotation_from_vector((0.0, 0.0, heading))
                self._canvas.place(trestle, places[index] - np.array((0.0, 0.0, 0.02)), turned)

    def close(self) -> None:
        """Release the scene."""
        self._canvas.close()
