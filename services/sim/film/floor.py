"""The floor of a film's scene: drawn as flat polygons behind everything, which is faster than rendering it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from PIL import Image, ImageDraw

from services.sim.camera.canvas import Matrix, Picture, pixel
from shared.spatial import Array

TILE = 0.5
"""Width [m] of a square."""
_ASIDE, _NEAR, _FAR = 7.0, 2.4, 6.5
"""How far [m] from what the camera looks at its squares reach to either side, to the camera, and away."""
_LIGHT, _DARK, _SHADE = (223, 226, 230), (206, 210, 216), (164, 169, 177)
TRACE = (120, 150, 190)
"""Colour of what is drawn on the floor."""


class Floor:
    """Draws what is behind everything else in a picture.

    Args:
        size: of the pictures, width and height [px].
    """

    def __init__(self, size: tuple[int, int]) -> None:
        self._size = size

    def draw(
        self, centre: Array, view: Matrix, projection: Matrix, shadows: Iterable[Array], outlines: Iterable[Array]
    ) -> Picture:
        """Nothing but the floor (height, width, 3): the camera looks down so far that it sees no horizon.

        Args:
            centre: what the camera looks at (2,) [m]; it looks along y.
            view: matrix of the camera.
            projection: matrix of the camera.
            shadows: convex polygons (n, 2) [m] on the floor.
            outlines: polygons (n, 2) [m] drawn as lines.
        """
        picture = Image.new("RGB", self._size, _LIGHT)
        pen = ImageDraw.Draw(picture)

        def seen(points: Array) -> list[tuple[float, float]]:
            """Where points (n, 2) [m] of the floor appear."""
            whole = np.column_stack((points, np.zeros(len(points))))
            return [(x, y) for x, y in pixel(whole, view, projection, self._size).tolist()]

        first = np.floor((centre - (_ASIDE, _NEAR)) / TILE).astype(int)
        columns, rows = round(2.0 * _ASIDE / TILE), round((_NEAR + _FAR) / TILE)
        grid = seen(TILE * (first + np.array([(i, j) for i in range(columns + 1) for j in range(rows + 1)])))
        for i in range(columns):
            for j in range(rows):
                corner = i * (rows + 1) + j
                corners = (corner, corner + rows + 1, corner + rows + 2, corner + 1)
                if (first.sum() + i + j) % 2:
                    pen.polygon([grid[index] for index in corners], fill=_DARK)
        for shadow in shadows:
            pen.polygon(seen(shadow), fill=_SHADE)
        for outline in outlines:
            points = seen(outline)
            pen.line([*points, points[0]], fill=TRACE, width=3, joint="curve")
        return np.array(picture)


def disc(centre: Sequence[float] | Array, radius: float) -> Array:
    """A round polygon (24, 2) [m]."""
    angles = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    return np.asarray(centre) + radius * np.column_stack((np.cos(angles), np.sin(angles)))


def hull(points: Array) -> Array:
    """Convex hull (m, 2) of points (n, 2), anticlockwise."""
    ordered = sorted(map(tuple, points.tolist()))

    def half(row: Iterable[tuple[float, float]]) -> list[tuple[float, float]]:
        kept: list[tuple[float, float]] = []
        for x, y in row:
            while len(kept) > 1:
                (ax, ay), (bx, by) = kept[-2:]
                if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0.0:
                    break
                kept.pop()
            kept.append((x, y))
        return kept[:-1]

    return np.array(half(ordered) + half(reversed(ordered)))
