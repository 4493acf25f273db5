"""What the limits leave of each axis: caps, thresholds and reserve, recomputed only when these change."""

from __future__ import annotations

import math

import numpy as np

from shared.spatial import Array

AXES = ("x", "y", "z", "about x", "about y", "about z")
_UNITS = ("N", "N", "N", "Nm", "Nm", "Nm")
_SHARE = 1.0 / 6.0
"""Share of what is left of V <= 1 that each axis may use in one command (rounded form)."""

_MARGIN = 1.02
"""Factor on an error bound that is taken over."""
_LARGEST_MARGIN = 1.05
"""Factor up to which a bound that has become smaller is kept."""


def _covers(kept: float, error: float) -> bool:
    return error <= kept <= _LARGEST_MARGIN * error


class Caps:
    """Caps of the twelve rows for limits ``wbar`` and error bounds ``eps``.

    Args:
        reserve: share of the limit that pressing leaves.
        yield_start: rho, share of the limit where yielding begins; 1 = strict.

    Attributes:
        refusal: why the limits cannot be kept, or None.
        errors: eps (6,) with a margin, see ``update``.
        start: theta = rho W (6,) with ``W = wbar - eps``.
        room: X = W - theta (6,).
        threshold: (6,) up to which a measured wrench makes nothing yield: theta, or the wall in the strict form.
        most: C (6,), cap that nothing may pass at rest: W, and in the rounded form up to 2 eps less.
        wall: C + 2 eps (6,): at rest no measured wrench is larger, so a larger one proves that the environment moved.
        levels: (3, 12) caps of the twelve rows for the next period, lasting, and lasting with the reserve, as long as
            nothing yields; another array whenever they change.
    """

    def __init__(self, reserve: float, yield_start: float) -> None:
        self._reserve, self._rho = reserve, yield_start
        self._limits: list[float] = []
        self.errors = [0.0] * 6
        self._given: list[float] = []  # the bounds as they were when ``_errors`` was chosen
        self.refusal: str | None = None
        self.force = [0.0] * 3
        self.wall = self.start = self.room = self.most = self.threshold = [0.0] * 6
        self.levels = np.zeros((3, 12))
        self._kept = np.zeros(12)

    def update(self, limit: Array, error_bound: Array) -> None:
        """Take limits (6,) and error bounds (6,) [N, Nm], finite; the latter with a margin of a few percent.

        The margin lets the caps stay the same while the error bound varies with the attitude.
        """
        limits, errors = limit.tolist(), error_bound.tolist()
        if limits == self._limits and (errors == self._given or all(map(_covers, self.errors, errors))):
            return
        self._given = errors
        self.refusal = _refusal(limits, errors)
        self._limits, self.errors = limits, [_MARGIN * error for error in errors]
        if self.refusal is not None:
            return
        error_bound = np.array(self.errors)
        self.force = limits[:3]
        W = limit - error_bound
        room = (1.0 - self._rho) * W
        self.start = (self._rho * W).tolist()
        self.room = room.tolist()
        # Proof of a moving environment comes the sooner the lower C is; half of the room is what yielding needs.
        most = np.maximum(W - 2.0 * error_bound, W - 0.5 * room) if self._rho < 1.0 else W
        self.most = most.tolist()
        self.wall = (most + 2.0 * error_bound).tolist()
        self.threshold = self.start if self._rho < 1.0 else self.wall
        # rho_i = max(reserve W_i, 3 eps_i): a smaller one would vanish in the measurement's error.
        self._kept = np.tile(np.maximum(self._reserve * W, 3.0 * error_bound), 2)
        self.levels = self._levels(self.rounded([0.0] * 6) if self._rho < 1.0 else W.tolist())

    def rounded(self, h: list[float]) -> list[float]:
        """Caps (6,) ``A_i = min(C_i, theta_i + X_i sqrt(h_i^2 + left/6))``, ``left = max(0, 1 - |h|^2)``."""
        left = _SHARE * max(0.0, 1.0 - sum(value * value for value in h))
        return [
            min(most, start + room * math.sqrt(value * value + left))
            for most, start, room, value in zip(self.most, self.start, self.room, h, strict=True)
        ]

    def levels_at(self, h: list[float]) -> Array:
        """The levels (3, 12) of the rounded form while axes are beyond their thresholds by ``h`` (6,)."""
        return self._levels(self.rounded(h))

    def _levels(self, cap: list[float]) -> Array:
        levels = np.empty((3, 12))
        levels[:2] = cap + cap
        np.subtract(levels[0], self._kept, out=levels[2])
        return levels


def _refusal(limit: list[float], error_bound: list[float]) -> str | None:
    """Why such limits cannot be kept: what an error leaves of them must exceed twice the error."""
    for axis in range(6):
        if not (error_bound[axis] >= 0.0 and limit[axis] - error_bound[axis] > 2.0 * error_bound[axis]):
            unit = _UNITS[axis]
            return (
                f"the limit {limit[axis]:g} {unit} {AXES[axis]} is not above three times its error bound "
                f"{error_bound[axis]:.3g} {unit}: raise the limit, tare the sensor or lower its noise"
            )
    return None
