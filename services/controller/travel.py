"""Travel that was commanded and that the measured wrench does not contain yet."""

from __future__ import annotations

import math

import numpy as np

from shared.spatial import Array

_ROWS = 512
_MOST_SEGMENTS = 256
_INSTANT = 1e-9
"""Times closer than this [s] are equal."""


class Travel:
    """Commanded travel still in flight, per axis and per sense; never nets one sense against the other.

    The robot is a delay d and a lag tau of unit area: of a command given at age ``a`` the share ``exp(-(a - d)/tau)``
    is still to act. Which command acts at an instant is not known exactly, because transport varies and commands are
    lost; certain is only that none acts for longer than T. So every instant is counted with the largest of the
    commands that may be acting (docs/guarantee.md, "Travel in flight").

    Args:
        period: T [s], longest time that one command acts.
        delay: d [s], sensor latency plus command delay, upper bound.
        lag: tau [s] of the robot's response.

    Attributes:
        in_flight: (12,) travel [m, rad] in the + senses, then in the - senses.
    """

    def __init__(self, period: float, delay: float, lag: float) -> None:
        self.period, self.delay, self.lag = period, delay, lag
        self.in_flight = np.zeros(12)
        self._command = np.zeros(12)
        # Segments of time, the newest last: what was sent in each, and the largest that may have acted instead.
        self._sent = np.zeros((_ROWS, 12))
        self._acting = np.zeros((_ROWS, 12))
        self._durations: list[float] = []
        self._first = 0
        self._tail = np.zeros(12)

    def configure(self, period: float, delay: float, lag: float) -> None:
        """Change the timing [s]; what is in flight is counted with the new one."""
        self.period, self.delay, self.lag = period, delay, lag

    def advance(self, dt: float) -> Array:
        """Let ``dt`` [s] pass since the last command; returns the travel in flight (12,), owned by this object."""
        if dt > 0.0:
            held = min(dt, self.period)
            self._push(held, self._command)
            if dt > held:  # the robot zeroes a command that is older than T
                self._command[:] = 0.0
                self._push(dt - held, self._command)
            self._tail *= math.exp(-dt / self.lag) if self.lag > 0.0 else 0.0
        self._weigh()
        return self.in_flight

    def command(self, twist: Array) -> None:
        """Record the twist (6,) [m/s, rad/s] that is sent now."""
        np.maximum(twist, 0.0, out=self._command[:6])
        np.negative(twist, out=self._command[6:])
        np.maximum(self._command, 0.0, out=self._command)
        # It may act early, in place of earlier ones, by the spread of the delay: at most T less the interval.
        row = self._first + len(self._durations)
        early = self.period - (self._durations[-1] if self._durations else 0.0)
        for duration in reversed(self._durations):
            if early < _INSTANT:
                break
            row -= 1
            np.maximum(self._acting[row], self._command, out=self._acting[row])
            early -= duration

    def _push(self, duration: float, speeds: Array) -> None:
        row = self._first + len(self._durations)
        if row == _ROWS:
            row = self._compact()
        self._sent[row] = self._acting[row] = speeds
        # An earlier command may still act, as long as it is not older than T.
        age = 0.0
        for back, earlier in enumerate(reversed(self._durations), start=1):
            age += earlier
            if age > self.period - _INSTANT:
                break
            np.maximum(self._acting[row], self._sent[row - back], out=self._acting[row])
        self._durations.append(duration)
        if len(self._durations) > _MOST_SEGMENTS:
            self._merge_oldest()

    def _compact(self) -> int:
        count = len(self._durations)
        for rows in (self._sent, self._acting):
            rows[:count] = rows[self._first : self._first + count].copy()
        self._first = 0
        return count

    def _merge_oldest(self) -> None:
        """Count the two oldest segments as one in which the larger of both acted."""
        first = self._first
        for rows in (self._sent, self._acting):
            np.maximum(rows[first], rows[first + 1], out=rows[first + 1])
        self._durations[1] += self._durations.pop(0)
        self._first += 1

    def _weigh(self) -> None:
        """``s = sum over segments of speed * integral of the share that is still to act``."""
        d, tau = self.delay, self.lag
        weights: list[float] = []
        age = passed = 0.0
        keep = max(d, self.period)
        old = 0
        for duration in reversed(self._durations):
            old += age >= keep
            age += duration
            # Integral of the share from age 0: 1 up to d, exp(-(a - d)/tau) beyond.
            until = age if age <= d else d + (tau * (1.0 - math.exp((d - age) / tau)) if tau > 0.0 else 0.0)
            weights.append(until - passed)
            passed = until
        weights.reverse()
        for _ in range(old):  # wholly acted but for the lag, whose exponential the tail continues exactly
            self._tail += weights.pop(0) * self._acting[self._first]
            self._durations.pop(0)
            self._first += 1
        end = self._first + len(weights)
        np.dot(weights, self._acting[self._first : end], out=self.in_flight)
        self.in_flight += self._tail
