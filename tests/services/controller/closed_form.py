"""The laws' problem solved without a solver: bisection on the multiplier of its one Lyapunov row."""

from __future__ import annotations

import numpy as np

from shared.spatial import Array


def twist(error: Array, lower: Array, upper: Array, rate: float, weight: float) -> Array:
    """Minimiser v (6,) of ``|v|^2 + k gamma`` with ``e.v <= -(lambda/2)|e|^2 + gamma``, ``gamma >= 0``, in a box.

    For a multiplier nu in [0, k] of the row the minimiser over the box is ``clip(-nu e / 2)``; ``e.v`` falls as nu
    grows, so nu is where the row is met, or k where even that is not enough.
    """

    def at(nu: float) -> Array:
        return np.clip(-0.5 * nu * error, lower, upper)

    wanted = -0.5 * rate * float(error @ error)
    if float(error @ at(0.0)) <= wanted:
        return at(0.0)
    if float(error @ at(weight)) >= wanted:
        return at(weight)
    low, high = 0.0, weight
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if float(error @ at(middle)) > wanted else (low, middle)
    return at(high)


def shortened(v: Array, max_linear: float, max_angular: float) -> Array:
    """The twist scaled into both speed limits."""
    return v / max(1.0, np.linalg.norm(v[:3]) / max_linear, np.linalg.norm(v[3:]) / max_angular)
