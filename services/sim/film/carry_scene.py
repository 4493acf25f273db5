"""The scene of the carry's film: robot, panel, trestles and person in a room, seen from the side."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pybullet

from services.sim.camera.canvas import Canvas, Colour, Picture, pixel
from services.sim.camera.panel_shapes import PanelShapes
from services.sim.camera.view import Scenery
from services.sim.film.carry_recording import Moment
from services.sim.film.figure import Figure, posture
from services.sim.film.floor import Floor, disc, hull
from services.sim.scene.panel import SUPPORT_WIDTH
from shared.spatial import Array, rotation_from_vector

EYE = (0.35, -4.3, 1.75)
"""Of the camera, from what it looks at (3,) [m]."""
LOOKS_AT = (1.42, -0.2, 0.74)
"""From the base (3,) [m]: so far to the right that there is room for the displays there."""
FIELD_OF_VIEW = 31.0
"""Vertical [degrees]."""
NEAR, FAR = 1.0, 14.0
LIGHT = (1.6, -2.4, 4.0)
MARKER_THICKER = 30.0
"""Times that the marker is drawn as high above the panel as it is for the head, which is ten times as near."""
BASE_RADIUS = 0.27
_WOOD: Colour = (0.55, 0.43, 0.31, 1.0)
_BEAM = 0.05
_SPREAD = 0.16
"""Half the distance [m] of a trestle's feet along the panel."""


class CarryScene:
    """Poses what there is and renders it on the processor.

    Args:
        scenery: what does not change.
        size: of the pictures, width and height [px].
    """

    def __init__(self, scenery: Scenery, size: tuple[int, int]) -> None:
        self._size = size
        self._canvas = Canvas(LIGHT, 0.62, 0.42, 0.05)
        self._floor = Floor(size)
        self._panel = PanelShapes(self._canvas, scenery, MARKER_THICKER)
        self._half = 0.5 * np.array(scenery.panel_size)
        self._trestles = [_Trestle(self._canvas, scenery.panel_size[1]) for _ in range(2)]
        self._figure = Figure(self._canvas)
        self._projection = pybullet.computeProjectionMatrixFOV(FIELD_OF_VIEW, size[0] / size[1], NEAR, FAR)
        self._view: tuple[float, ...] = ()
        self._start: Array | None = None

    def picture(self, moment: Moment) -> Picture:
        """The scene as (height, width, 3) red, green, blue."""
        canvas = self._canvas
        canvas.stand(*moment.base.tolist())
        canvas.pose(moment.joints)
        self._panel.pose(moment.panel, moment.panel_rotation, moment.covered)
        for index, trestle in enumerate(self._trestles):
            trestle.pose(None if moment.trestles is None else moment.trestles[index])
        feet = self._stand_by(moment)
        target = np.array((*moment.centre, 0.0)) + LOOKS_AT
        self._view = pybullet.computeViewMatrix((target + EYE).tolist(), target.tolist(), (0, 0, 1))
        picture, nothing = canvas.render(*self._size, self._view, self._projection)
        if self._start is None:
            self._start = moment.base[:2].copy()
        shadows = [disc(moment.base[:2], 1.15 * BASE_RADIUS), self._under(moment), disc(feet, 0.26)]
        room = self._floor.draw(
            target[:2], self._view, self._projection, shadows, [disc(self._start, 1.3 * BASE_RADIUS)]
        )
        np.copyto(picture, room, where=nothing[:, :, None])
        return picture

    def _under(self, moment: Moment) -> Array:
        """The panel's shadow: a polygon (n, 2) [m] of the floor."""
        signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        corners = moment.panel + (signs * self._half).dot(moment.panel_rotation.T)
        return hull(corners[:, :2])

    def _stand_by(self, moment: Moment) -> Array:
        """Put the person at the panel's far edge; returns where that is (2,) [m]."""
        outward = moment.panel_rotation[:, 0] * (1.0, 1.0, 0.0)
        outward /= max(1e-6, float(np.linalg.norm(outward)))
        stance = posture(moment.hands, moment.panel_rotation[:, 1], outward, moment.holding)
        self._figure.pose(stance, outward)
        return stance.feet.mean(axis=0)[:2]

    def tool(self) -> tuple[float, float, float]:
        """Position [m] of the tool."""
        return self._canvas.tool()

    def pixel(self, point: Sequence[float] | Array) -> Array:
        """Where a point (3,) [m] of the world appears in the last picture: column and row (2,) [px]."""
        return pixel(point, self._view, self._projection, self._size)

    def close(self) -> None:
        """Release the scene."""
        self._canvas.close()


class _Trestle:
    """A beam on four legs.

    Args:
        canvas: where it is drawn.
        width: of the panel [m].
    """

    def __init__(self, canvas: Canvas, width: float) -> None:
        self._canvas = canvas
        self._reach = SUPPORT_WIDTH * width
        self._beam = canvas.box((_BEAM, 2.0 * self._reach + 0.1, _BEAM), _WOOD)
        self._legs: list[int] = []

    def pose(self, top: Array | None) -> None:
        """Put the middle of its upper edge at a place (3,) [m]; None takes it away."""
        if top is None:
            for body in (self._beam, *self._legs):
                self._canvas.hide(body)
            return
        height = float(top[2]) - _BEAM
        tilt = np.arctan2(_SPREAD, height)
        if not self._legs:
            size = (0.035, 0.035, float(np.hypot(_SPREAD, height)))
            self._legs = [self._canvas.box(size, _WOOD) for _ in range(4)]
        self._canvas.place(self._beam, top - np.array((0.0, 0.0, 0.5 * _BEAM)))
        places = [(along, across) for along in (-1.0, 1.0) for across in (-1.0, 1.0)]
        for leg, (along, across) in zip(self._legs, places, strict=True):
            middle = top + np.array((0.5 * along * _SPREAD, across * self._reach, -_BEAM - 0.5 * height))
            self._canvas.place(leg, middle, rotation_from_vector((0.0, -along * tilt, 0.0)))
