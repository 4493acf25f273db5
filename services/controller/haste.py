"""How quickly a moving environment is followed, learnt from whether the answer so far was enough."""

from __future__ import annotations

import math
from collections import deque

_RATE = 1.5
"""Growth per response time D, exponential."""
_LARGEST = 10.0
"""A contact that is softer than declared by more than this is answered too slowly."""


class Haste:
    """How much faster than the stiffest contact allows the form yields, because the present one shows to be softer.

    An answer that is right for the declared stiffness has stopped the wrench from growing a response time later. Where
    the wrench still grows then, the contact is softer, or the environment faster, and the answer may be larger; as
    soon as the wrench falls, it returns to what the stiffest contact allows.

    Attributes:
        factor: at least 1, on the yielding.
    """

    def __init__(self) -> None:
        self.factor = 1.0
        self._age = 0.0
        self._seen: deque[tuple[float, float]] = deque()

    def update(self, distance: float, response_time: float, dt: float) -> float:
        """The factor for a ``distance`` [1] of the wrench from the box, ``dt`` [s] after the last one."""
        self._age += dt
        self._seen.append((self._age, distance))
        while len(self._seen) > 1 and self._seen[1][0] <= self._age - response_time:
            self._seen.popleft()
        then, before = self._seen[0]
        if distance < before:
            self.factor = 1.0 + (self.factor - 1.0) * math.exp(-dt / response_time)
        elif distance > before and then <= self._age - response_time:
            self.factor = min(_LARGEST, self.factor * math.exp(_RATE * dt / response_time))
        return self.factor
