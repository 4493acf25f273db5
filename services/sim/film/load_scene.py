"""The scene of a film: the whole robot with its shapes and colours, floor, rope and bag, seen by a fixed camera."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import pybullet

from services.sim.camera.canvas import Canvas, Colour, Matrix, Picture, pixel
from services.sim.robot.kinematics import HOME
from services.sim.scene.bag import BAG_LENGTH, ROPE_LENGTH

CAMERA = (2.35, -2.25, 1.35)
LOOKS_AT = (0.16, 0.02, 0.66)
FIELD_OF_VIEW = 33.0
"""Vertical [degrees]."""
MOVING = (0.23, 0.74)
"""Columns, as shares of the width, between which everything moves; the rest of the picture is rendered once."""
NEAR, FAR = 0.1, 12.0
LIGHT = (1.6, -1.2, 3.0)
ROPE_BEADS = 24
_FLOOR: tuple[Colour, Colour] = ((0.86, 0.87, 0.88, 1.0), (0.79, 0.80, 0.82, 1.0))
_ROPE: Colour = (0.62, 0.50, 0.33, 1.0)
_SHADE: tuple[Colour, Colour] = ((0.97, 0.98, 1.0, 1.0), (0.90, 0.91, 0.93, 1.0))
_CLOTH: Colour = (0.30, 0.45, 0.33, 1.0)
_BAND: Colour = (0.80, 0.66, 0.25, 1.0)


class Scene:
    """Poses the robot and the bag and renders them on the processor.

    Args:
        width, height: size of the pictures [px].
    """

    def __init__(self, width: int, height: int) -> None:
        self._size = width, height
        self._canvas = Canvas(LIGHT, 0.62, 0.42, 0.06)
        self._tiles()
        # The renderer's own shadows treble its time and miss the floor; two discs do.
        self._shades = [
            self._canvas.shape(pybullet.GEOM_CYLINDER, shade, radius=radius, length=0.002)
            for shade, radius in zip(_SHADE, (0.33, 0.11), strict=True)
        ]
        self._canvas.place(self._shades[0], (-0.03, 0.02, 0.0))
        self._beads = [self._canvas.shape(pybullet.GEOM_SPHERE, _ROPE, radius=0.009) for _ in range(ROPE_BEADS)]
        self._bag = [
            self._canvas.shape(pybullet.GEOM_BOX, _CLOTH, halfExtents=[0.085, 0.065, 0.09]),
            self._canvas.shape(pybullet.GEOM_BOX, _BAND, halfExtents=[0.087, 0.067, 0.012]),
            self._canvas.shape(pybullet.GEOM_SPHERE, _CLOTH, radius=0.05),
        ]
        self._view = pybullet.computeViewMatrix(CAMERA, LOOKS_AT, (0, 0, 1))
        self._projection = self._window(0.0, 1.0)
        self._columns = round(MOVING[0] * width), round(MOVING[1] * width)
        self._moving = self._window(*(column / width for column in self._columns))
        self.pose(HOME, None)
        self._still = self._render(width, self._projection)

    def _tiles(self) -> None:
        half = 0.25
        for column in range(-6, 10):
            for row in range(-8, 9):
                tile = self._canvas.shape(pybullet.GEOM_BOX, _FLOOR[(column + row) % 2], halfExtents=[half, half, 0.01])
                self._canvas.place(tile, (2 * half * column, 2 * half * row, -0.01))

    def pose(self, joints: Mapping[str, float], bag_height: float | None) -> None:
        """Put the joints at their positions [m, rad] and the bag's bottom at its height [m]; None: there is no bag."""
        self._canvas.pose(joints)
        tool = self.tool()
        if bag_height is None:
            for body in (*self._beads, *self._bag, self._shades[1]):
                self._canvas.hide(body)
            return
        top = (tool[0], tool[1], bag_height + BAG_LENGTH)
        for bead, place in zip(self._beads, _rope(tool, top), strict=True):
            self._canvas.place(bead, place)
        self._canvas.place(self._shades[1], (top[0], top[1], 0.001))
        for part, above in zip(self._bag, (0.09, 0.13, 0.19), strict=True):
            self._canvas.place(part, (top[0], top[1], bag_height + above))

    def tool(self) -> tuple[float, float, float]:
        """Position [m] of the tool."""
        return self._canvas.tool()

    def picture(self) -> Picture:
        """The scene as (height, width, 3) red, green, blue."""
        left, right = self._columns
        picture = self._still.copy()
        picture[:, left:right] = self._render(right - left, self._moving)
        return picture

    def _window(self, left: float, right: float) -> Matrix:
        """Projection matrix of the columns between two shares of the width."""
        width, height = self._size
        top = NEAR * math.tan(math.radians(FIELD_OF_VIEW) / 2.0)
        side = top * width / height
        matrix: Matrix = pybullet.computeProjectionMatrix(
            (2.0 * left - 1.0) * side, (2.0 * right - 1.0) * side, -top, top, NEAR, FAR
        )
        return matrix

    def _render(self, width: int, projection: Matrix) -> Picture:
        return self._canvas.render(width, self._size[1], self._view, projection)[0]

    def pixel(self, point: Sequence[float]) -> tuple[float, float]:
        """Where a point [m] of the world appears in the picture: column and row [px]."""
        column, row = pixel(point, self._view, self._projection, self._size)
        return float(column), float(row)

    def close(self) -> None:
        """Release the scene."""
        self._canvas.close()


def _rope(tool: Sequence[float], top: Sequence[float]) -> list[tuple[float, float, float]]:
    """Positions of the rope's beads from the tool to the bag; a slack rope bulges sideways."""
    span = math.dist(tool, top)
    # A parabola of sag b over a span s is about s + 8 b^2 / (3 s) long.
    bulge = math.sqrt(max(0.0, 3.0 / 8.0 * span * (ROPE_LENGTH - span)))
    places = []
    for bead in range(ROPE_BEADS):
        along = bead / (ROPE_BEADS - 1)
        sideways = 4.0 * bulge * along * (1.0 - along)
        x, y, z = (a + along * (b - a) for a, b in zip(tool, top, strict=True))
        places.append((x + 0.7 * sideways, y - 0.7 * sideways, z))
    return places
