"""The limits and the nominal wrench in force: those of the target, without a jump when it changes them in contact."""

from __future__ import annotations

import numpy as np

from shared.spatial import Array

_RAMP_RATE = 2.0
"""Change per second in shares of the limit: a limit is halved in 0.35 s, the nominal wrench moves by it in 0.5 s."""


class LimitsInForce:
    """Follows the target's limits and nominal wrench.

    A limit that rises holds at once. One that falls, and the nominal wrench, are ramped: until then the promise is the
    limit that is still in force (docs/guarantee.md, "Changing limits").

    Attributes:
        limit: wbar (6,) [N, Nm] in force.
        nominal: (6,) [N, Nm] in force.
    """

    def __init__(self) -> None:
        self.limit = np.full(6, np.inf)
        self.nominal = np.zeros(6)
        self._begun = False
        self._reached: tuple[Array, Array] | None = None  # limit and nominal wrench of the target, once in force

    def follow(self, limit: Array, nominal: Array, dt: float) -> None:
        """Move towards the target's limit and nominal wrench (6,), ``dt`` [s] after the last call.

        Neither is written to later: the same arrays are the same target.
        """
        reached = self._reached
        if reached is not None and limit is reached[0] and nominal is reached[1]:
            return
        if not self._begun:
            self._begun = True
            self.limit, self.nominal = limit.copy(), nominal.copy()
            return
        step = min(1.0, _RAMP_RATE * dt) * self.limit
        self.limit = np.maximum(limit, self.limit - step)
        self.nominal = np.minimum(np.maximum(nominal, self.nominal - step), self.nominal + step)
        arrived = np.array_equal(self.limit, limit) and np.array_equal(self.nominal, nominal)
        self._reached = (limit, nominal) if arrived else None
