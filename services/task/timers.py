"""Conditions that have to last, so that no single sample decides."""

from __future__ import annotations

import math


class Sustained:
    """True once a condition has held without a break for ``duration`` [s]."""

    def __init__(self, duration: float) -> None:
        self._duration = duration
        self.time = 0.0

    def update(self, condition: bool, dt: float) -> bool:
        """Account for ``dt`` [s] with the condition."""
        self.time = self.time + dt if condition else 0.0
        return self.reached

    @property
    def reached(self) -> bool:
        """Whether it was true at the last update."""
        return self.time >= self._duration

    def reset(self) -> None:
        """Begin anew."""
        self.time = 0.0


class LeakyTimer:
    """True once a condition has held for ``duration`` [s] more than it has not: noise delays it and cannot block it."""

    def __init__(self, duration: float) -> None:
        self._duration = duration
        self.time = 0.0

    def update(self, condition: bool, dt: float) -> bool:
        """Account for ``dt`` [s] with the condition."""
        self.time = min(self._duration, max(0.0, self.time + (dt if condition else -dt)))
        return self.time >= self._duration - 1e-9

    def reset(self) -> None:
        """Begin anew."""
        self.time = 0.0


class LowPass:
    """First-order low pass of time constant ``constant`` [s]; begins at the first value."""

    def __init__(self, constant: float) -> None:
        self._constant = constant
        self.value: float | None = None

    def update(self, value: float, dt: float) -> float:
        """The filtered value after ``dt`` [s]."""
        if self.value is None:
            self.value = value
        else:
            self.value += (1.0 - math.exp(-dt / self._constant)) * (value - self.value)
        return self.value
