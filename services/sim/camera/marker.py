"""The ArUco marker on the panel: which cells are black, and where it sticks."""

from __future__ import annotations

import numpy as np

from shared.spatial import Array

DICT_4X4_50 = bytes.fromhex(
    "b532 0f9a 332d 9946 549e 79cd 9e2e c4f2 feda cf56 f991 11a7 0eb7 2a0f 24b1 263e 4665 "
    "6600 6c5e 76af 868b b02b ccd5 dd82 fe47 9471 ace4 a554 2123 346f 4415 57b2 9ecf f0cb "
    "08ae 0929 1875 04ff 0df6 1c5a 1718 2a28 328c 38b2 24e8 2eeb 2d3f 4b64 502e 5013 "
)
"""The inner 4 x 4 cells of each marker in two bytes, row by row, most significant bit first, 1 = white: OpenCV's
dictionary."""
CELLS = 6  # along each side: four inner ones, and the black border
MARGIN = 1.0  # [cells] of the white around it: without it nobody finds the marker on a dark background
ROTATION: Array = np.array(((0.0, 1.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
"""Rotation of the marker's frame (x right, y up, z towards who looks at it) in the panel's: upright for the robot."""


def black(identity: int) -> np.ndarray:
    """Which cells (6, 6) of a marker are black, its upper row first."""
    number = int.from_bytes(DICT_4X4_50[2 * identity : 2 * identity + 2], "big")
    inner = [(number >> (15 - index)) & 1 == 0 for index in range(16)]
    cells = np.ones((CELLS, CELLS), dtype=bool)
    cells[1:-1, 1:-1] = np.reshape(inner, (4, 4))
    return cells


def strips(identity: int) -> list[tuple[float, float, float, float]]:
    """The black cells as rectangles: left, right, lower and upper edge, in cells from the marker's centre."""
    half = CELLS / 2.0
    found = []
    for row, cells in enumerate(black(identity)):
        column = 0
        while column < CELLS:
            if not cells[column]:
                column += 1
                continue
            begin = column
            while column < CELLS and cells[column]:
                column += 1
            found.append((begin - half, column - half, half - row - 1.0, half - row))
    return found


def corners(size: float) -> Array:
    """Corners (4, 3) [m] of a marker of ``size`` [m], in its frame: clockwise from upper left."""
    half = 0.5 * size
    return np.array(((-half, half, 0.0), (half, half, 0.0), (half, -half, 0.0), (-half, -half, 0.0)))
