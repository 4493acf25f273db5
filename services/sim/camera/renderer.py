"""What the head's camera sees: robot, panel and marker, rendered on the processor."""

from __future__ import annotations

import io
import math

import numpy as np
import pybullet
from PIL import Image

from services.sim.camera.canvas import Canvas, Picture
from services.sim.camera.panel_shapes import PanelShapes
from services.sim.camera.view import FOCAL_LENGTH, HEIGHT, WIDTH, Scenery, View
from services.sim.scene.panel import SUPPORTS
from shared.spatial import rotation_from_vector

BACKGROUND = (184, 184, 178)  # of floor and all else: to render a floor takes longer than all the rest
NEAR, FAR = 0.05, 8.0  # [m] of what is drawn
QUALITY = 90  # of the JPEG images
LIGHT_FROM = (-1.0, -2.0, 4.0)
_BEAM = 0.03  # [m] of a trestle's upper beam


class Renderer:
    """Poses the scene and renders it.

    Args:
        scenery: what does not change.
    """

    def __init__(self, scenery: Scenery) -> None:
        self._scenery = scenery
        self._random = np.random.default_rng(scenery.seed)
        self._canvas = Canvas(LIGHT_FROM, 0.6 * scenery.light, 0.4 * scenery.light, 0.0)
        size = (0.04, 0.8 * scenery.panel_size[1], _BEAM)
        self._trestles = [self._canvas.box(size, (0.45, 0.36, 0.28, 1.0)) for _ in SUPPORTS]
        self._panel = PanelShapes(self._canvas, scenery)
        self._projection = pybullet.computeProjectionMatrixFOV(
            math.degrees(2.0 * math.atan(0.5 * HEIGHT / FOCAL_LENGTH)), WIDTH / HEIGHT, NEAR, FAR
        )

    def picture(self, view: View) -> Picture:
        """What the camera sees (height, width, 3): red, green, blue."""
        self._pose(view)
        forward, down = view.rotation[:, 2], view.rotation[:, 1]
        matrix = pybullet.computeViewMatrix(
            view.position.tolist(), (view.position + forward).tolist(), (-down).tolist()
        )
        picture, nothing = self._canvas.render(WIDTH, HEIGHT, matrix, self._projection)
        picture[nothing] = np.minimum(self._scenery.light * np.array(BACKGROUND), 255.0).astype(np.uint8)
        if self._scenery.noise == 0.0 and view.brighter == 0.0:
            return picture
        grain = self._scenery.noise * self._random.standard_normal(picture.shape, dtype=np.float32)
        return np.clip(picture + (grain + np.float32(view.brighter)), 0.0, 255.0).astype(np.uint8)

    def jpeg(self, view: View) -> bytes:
        """The same as a JPEG image."""
        file = io.BytesIO()
        Image.fromarray(self.picture(view)).save(file, "JPEG", quality=QUALITY)
        return file.getvalue()

    def _pose(self, view: View) -> None:
        self._canvas.pose(view.joints)
        self._panel.pose(view.panel, view.panel_rotation, view.covered)
        for index, trestle in enumerate(self._trestles):
            if view.supports is None:
                self._canvas.hide(trestle)
            else:
                places, heading = view.supports
                turned = rotation_from_vector((0.0, 0.0, heading))
                self._canvas.place(trestle, places[index] - np.array((0.0, 0.0, 0.02)), turned)

    def close(self) -> None:
        """Release the scene."""
        self._canvas.close()
