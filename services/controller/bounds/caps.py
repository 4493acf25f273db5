"""What the limits leave of each axis: caps, thresholds and reserve, recomputed only when these change.

A limit that falls below what presses already or may still come of what is in flight is lowered as far as these let it.
At a sample with the load ``u = |w| + M s`` the bound P on the true wrench becomes ("Changing limits" in
docs/guarantee.md)::

    P = C + eps                                              if u <= C on every axis
    P = max(C + eps, min(P, max(u/0.9, u + 3 eps) + eps))    else: each axis keeps room to retreat in
"""

from __future__ import annotations

import math
import operator

import numpy as np

from shared.spatial import Array

AXES = ("x", "y", "z", "about x", "about y", "about z")
UNITS = ("N", "N", "N", "Nm", "Nm", "Nm")
_SHARE = 1.0 / 6.0
"""Share of what is left of V <= 1 that each axis may use in one command (rounded form)."""

_ROOM = 0.9
"""Share of the bound in force that the load may fill while that is lowered: the rest is what retreating needs."""

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
        yield_start: r, share of the limit where yielding begins; 1 = strict.

    Attributes:
        refusal: why the limits cannot be kept, or None.
        errors: eps (6,) with a margin, see ``update``.
        start: theta = r W (6,) with ``W = wbar - eps``.
        room: X = W - theta (6,).
        promise: P (6,) that no true wrench passes at rest; None before the first ``lower``.
        lowering: some axis of ``promise`` is above what belongs to the limits.
        shifted: the nominal wrench has moved since it was not: what presses now may be what it carried.
        threshold: (6,) up to which a measured wrench makes nothing yield: theta; in the strict form the wall, or while
            the promise is being lowered what the reserve leaves.
        most: P - eps (6,), cap that nothing may pass at rest: C, which is W, and in the rounded form up to 2 eps less.
        wall: P + eps (6,): at rest no measured wrench is larger, so a larger one proves that the environment moved.
        force: (3,) [N], largest force by limit or promise.
        levels: (3, 12) caps of the twelve rows for the next period, lasting, and lasting with the reserve, as long as
            nothing yields; another array whenever they change.
    """

    def __init__(self, reserve: float, yield_start: float) -> None:
        self._reserve, self._yield_start = reserve, yield_start
        self._limits: list[float] = []
        self.errors = [0.0] * 6
        self._given: list[float] = []  # the bounds as they were when ``_errors`` was chosen
        self.refusal: str | None = None
        self.promise: list[float] | None = None
        self.lowering = self.shifted = False
        self.force = [0.0] * 3
        self.wall = self.start = self.room = self.most = self.threshold = self._cap = self._aim = [0.0] * 6
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
        W = limit - error_bound
        room = (1.0 - self._yield_start) * W
        self.start = (self._yield_start * W).tolist()
        self.room = room.tolist()
        # Proof of a moving environment comes the sooner the lower C is; half of the room is what yielding needs.
        cap = np.maximum(W - 2.0 * error_bound, W - 0.5 * room) if self._yield_start < 1.0 else W
        self._cap = cap.tolist()
        self._aim = (cap + error_bound).tolist() if self._yield_start < 1.0 else limits  # not W + eps: that rounds
        # rho_i = max(reserve W_i, 3 eps_i): a smaller one would vanish in the measurement's error.
        self._kept = np.tile(np.maximum(self._reserve * W, 3.0 * error_bound), 2)
        self.levels = self._levels(self.rounded([0.0] * 6) if self._yield_start < 1.0 else W.tolist())
        if self.promise is not None:
            self._keep([max(kept, aim) for kept, aim in zip(self.promise, self._aim, strict=True)])

    def shift(self, by: Array) -> None:
        """The nominal wrench has moved by (6,) [N, Nm]: what held about the old one holds about it in a wider box."""
        if self.promise is not None and by.any():
            self.shifted = True
            self._keep([kept + abs(change) for kept, change in zip(self.promise, by.tolist(), strict=True)])

    def lower(self, load: Array) -> None:
        """Lower the promise as far as the load lets it.

        Args:
            load: (12,) [N, Nm] measured wrench and what is in flight can add to it: ``w + M s``, then ``-w + M s``.
        """
        load = np.maximum(load[:6], load[6:]).tolist()
        if all(map(operator.le, load, self._cap)):
            self._keep(self._aim)
            return
        needed = (max(u / _ROOM, u + 3.0 * error) + error for u, error in zip(load, self.errors, strict=True))
        kept = self.promise or [math.inf] * 6
        self._keep([max(aim, min(both)) for aim, *both in zip(self._aim, kept, needed, strict=True)])

    def _keep(self, promise: list[float]) -> None:
        """Take over the promise, and what follows from it."""
        self.lowering = any(map(operator.gt, promise, self._aim))
        self.shifted = self.shifted and self.lowering
        self.promise = promise if self.lowering else self._aim
        self.force = list(map(max, self._limits[:3], self.promise[:3]))
        self.most = [kept - error for kept, error in zip(self.promise, self.errors, strict=True)]
        self.wall = [kept + error for kept, error in zip(self.promise, self.errors, strict=True)]
        if self._yield_start < 1.0:
            self.threshold = self.start
        else:
            self.threshold = [max(0.0, left) for left in self.levels[2, :6].tolist()] if self.lowering else self.wall

    def rounded(self, h: list[float]) -> list[float]:
        """Caps (6,) ``A_i = min(C_i, theta_i + X_i sqrt(h_i^2 + left/6))``, ``left = max(0, 1 - |h|^2)``."""
        left = _SHARE * max(0.0, 1.0 - sum(value * value for value in h))
        return [
            min(most, start + room * math.sqrt(value * value + left))
            for most, start, room, value in zip(self._cap, self.start, self.room, h, strict=True)
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
            unit = UNITS[axis]
            return (
                f"the limit {limit[axis]:g} {unit} {AXES[axis]} is not above three times its error bound "
                f"{error_bound[axis]:.3g} {unit}: raise the limit, or let go of the tool and `tandem tare`"
            )
    return None
