"""The laws' formulas a second time, element by element and without a solver."""

from __future__ import annotations

import itertools

import numpy as np

from shared.spatial import Array


def rows(stiffness: Array, low: Array) -> Array:
    """M (12, 12) of Kbar (6, 6) and low (6,).

    Motion in direction j changes row i by Kbar, but by low_i where it makes the row's own side of w_i fall.
    """
    M = np.zeros((12, 12))
    for i, j in itertools.product(range(12), repeat=2):
        M[i, j] = low[i % 6] if abs(i - j) == 6 else stiffness[i % 6, j % 6]
    return M


def both_senses(vector: Array) -> Array:
    """What a vector (6,) adds to the twelve rows: itself to the upper ones, its negative to the lower ones."""
    return np.concatenate((vector, -vector))


def twist(error: Array, lower: Array, upper: Array, rate: float, weight: float) -> Array:
    """Minimiser v (6,) of ``|v|^2 + k gamma`` with ``e.v <= -(lambda/2)|e|^2 + gamma``, ``gamma >= 0``, in a box.

    For a multiplier nu in [0, k] of the row the minimiser over the box is ``clip(-nu e / 2)``; ``e.v`` falls as nu
    grows, so nu is where the row is met, or k where even that is not enough: bisection finds it.
    """

    def at(nu: float) -> Array:
        return np.clip(-0.5 * nu * error, lower, upper)

    wanted = -0.5 * rate * float(error @ error)
    low, high = 0.0, weight
    if float(error @ at(low)) <= wanted:
        return at(low)
    if float(error @ at(high)) >= wanted:
        return at(high)
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if float(error @ at(middle)) > wanted else (low, middle)
    return at(high)


def shortened(v: Array, max_linear: float, max_angular: float) -> Array:
    """The twist scaled into both speed limits."""
    return v / max(1.0, np.linalg.norm(v[:3]) / max_linear, np.linalg.norm(v[3:]) / max_angular)
