"""Corners of a dark square to a few hundredths of a pixel: lines through its edges, and where they meet.

The usual refinement looks at each corner alone, which blur rounds: at 35 px it leaves every corner a quarter of a pixel
too far inside, 2 % of the distance. An edge stays where it is under blur, and has a hundred times as many pixels.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from shared.spatial import Array

Sampler = Callable[[Array], Array]
"""Brightness (n,) at points (n, 2) [px]."""

MODULES = 6  # of a marker along each side: its code, and the black border
_SPAN = np.linspace(0.1, 0.9, 33)  # [1] of an edge, without its ends, where the next edge begins
_ACROSS = np.linspace(-1.0, 1.0, 25)  # [1] of the reach to either side of an edge
_REACH = 0.75  # [modules] to either side of an edge: less than the border's width, inside and outside
_FARTHEST = 4.0  # [px] of that reach at most: no blur of use reaches farther, and noise grows with it
_SMALLEST = 1.0  # [px] of a module below which the border is no strip any more
_LEAST_CONTRAST = 8.0  # [of 255] between inside and outside of an edge
_ROUNDS = 3  # of refinement: each begins at better corners
_OUTLIER = 3.0  # [1] median distances from a line beyond which a point is none of its edge


def refined(corners: Array, sample: Sampler) -> Array | None:
    """Corners (4, 2) [px] of a square, or None where no edge is to be seen.

    Args:
        corners: rough corners (4, 2) [px], in order.
        sample: the image's brightness.
    """
    for _ in range(_ROUNDS):
        lines = [_line(np.roll(corners, -edge, axis=0), sample) for edge in range(4)]
        fitted = [line for line in lines if line is not None]
        if len(fitted) < 4:
            return None
        met = [_crossing(fitted[edge - 1], fitted[edge]) for edge in range(4)]
        moved = np.array(met)
        if not np.isfinite(moved).all() or np.abs(moved - corners).max() > _span(corners) / MODULES:
            return None
        corners = moved
    return corners


def _span(corners: Array) -> float:
    """Longest side [px]."""
    return float(np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1).max())


def _line(corners: Array, sample: Sampler) -> tuple[Array, Array] | None:
    """A point and the unit direction (2,) of the line through the edge from corner 0 to corner 1."""
    centres = corners[0] + _SPAN[:, None] * (corners[1] - corners[0])
    opposite = corners[3] + _SPAN[:, None] * (corners[2] - corners[3])
    # Across the edge along the square's other sides, not at right angles: a square seen from the side is a lozenge.
    module = (opposite - centres) / MODULES
    length = np.linalg.norm(module, axis=1)
    if length.min() < _SMALLEST:
        return None
    reach = module * np.minimum(_REACH, _FARTHEST / length)[:, None]
    points = centres[:, None, :] + _ACROSS[None, :, None] * reach[:, None, :]
    steps = np.diff(sample(points.reshape(-1, 2)).reshape(len(_SPAN), len(_ACROSS)), axis=1)
    contrast = steps.sum(axis=1)
    typical = float(np.median(contrast))
    seen = contrast * np.sign(typical) > abs(typical) / 2
    if abs(typical) < _LEAST_CONTRAST or seen.sum() < len(_SPAN) // 2:
        return None
    # The centroid of the slope is where the edge is, however it is blurred, as long as the blur is symmetric.
    middle = (_ACROSS[1:] + _ACROSS[:-1]) / 2
    on_edge = centres[seen] + ((steps[seen] @ middle) / contrast[seen])[:, None] * reach[seen]
    good = np.ones(len(on_edge), dtype=bool)
    for _ in range(2):
        centre = on_edge[good].mean(axis=0)
        direction = np.linalg.svd(on_edge[good] - centre)[2][0]
        away = np.abs((on_edge - centre) @ np.array((-direction[1], direction[0])))
        good = away <= _OUTLIER * max(float(np.median(away)), 0.02)
        if good.sum() < len(_SPAN) // 3:
            return None
    return centre, direction


def _crossing(one: tuple[Array, Array], other: tuple[Array, Array]) -> Array:
    """Where two lines meet (2,); infinite if they are parallel."""
    (p, u), (q, v) = one, other
    determinant = u[0] * v[1] - u[1] * v[0]
    if abs(determinant) < 1e-6:
        return np.full(2, np.inf)
    gap = q - p
    return p + (gap[0] * v[1] - gap[1] * v[0]) / determinant * u
