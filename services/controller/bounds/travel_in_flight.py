"""Travel that was commanded and that the measured wrench does not contain yet."""

from __future__ import annotations

import math

import numpy as np

from shared.spatial import Array

_ROWS, _MOST_SEGMENTS = 512, 256
"""Segments for which there is room, and that are kept at most."""
_OLD_SEGMENTS = 4
"""So many segments that have acted but for the lag are folded into one together, which is faster."""
_FORGETTING = 1.01
"""Factor per command with which the shortest interval between commands is forgotten."""
_NONE = np.zeros(12)
SENSES = np.vstack((-np.eye(6), np.eye(6)))
"""(12, 6), takes a motion's elements to the twelve directions; the negative ones are its motion the other way."""
GROW, FALL = slice(0, 6), slice(6, 12)
"""The directions that make the wrench's axes grow, along -x, -y, -z and about them, and those that make them fall."""

_INSTANT = 1e-9
"""Times closer than this [s] are equal."""


def directed(twist: Array) -> Array:
    """The speeds (12,) [m/s, rad/s] of a twist (6,) in the twelve directions, each >= 0."""
    return np.maximum(SENSES.dot(twist), 0.0)


class TravelInFlight:
    """Commanded travel still in flight, per axis and per sense; never nets one sense against the other.

    The robot is a delay d and a lag tau of unit area. Of the speed u that acts at age a a share is still to come::

        s = integral of u(a) share(a) da,  share(a) = 1 for a <= d, exp(-(a - d)/tau) beyond

    Which command acts at an instant is not known exactly, because transport varies and commands are lost; certain is
    only that none acts for longer than T. So every instant is counted with the largest speed that may be acting
    (docs/guarantee.md, "Travel in flight").

    Twelve directions, here and wherever a vector has twelve elements: first the motions along -x, -y, -z and about
    them, which make the wrench's axis grow, then those along +x, +y, +z and about them, which make it fall.

    Args:
        period: T [s], longest time that one command acts.
        delay: d [s], sensor latency plus command delay, upper bound.
        lag: tau [s] of the robot's response.

    Attributes:
        in_flight: (12,) travel [m, rad] in the twelve directions.
        speeds: (12,) last command [m/s, rad/s] in the twelve directions, each >= 0.
    """

    def __init__(self, period: float, delay: float, lag: float) -> None:
        self.period, self.delay, self.lag = period, delay, lag
        self.in_flight = np.zeros(12)
        self.speeds = np.zeros(12)
        # Segments of time, the newest last: what was sent in each, and the largest that may have acted instead. The
        # row before the first one holds what the lag has left of all older ones when they were folded into it, of
        # which the share ``_tail`` is still to act.
        self._sent = np.zeros((_ROWS, 12))
        self._acting = np.zeros((_ROWS, 12))
        self._durations: list[float] = []
        self._first = 1
        self._tail = 0.0
        self._just_sent = False
        self._interval = 0.0  # [s] shortest recent one between two commands, 0 = not known yet

    def configure(self, period: float, delay: float, lag: float) -> None:
        """Change the timing [s]; what is in flight is counted with the new one."""
        self.period, self.delay, self.lag = period, delay, lag

    def advance(self, dt: float) -> Array:
        """Let ``dt`` [s] pass since the last command; returns the travel in flight (12,), owned by this object."""
        if dt > 0.0:
            if dt <= self.period:
                self._push(dt)
                self._interval = min(dt, _FORGETTING * self._interval) if self._interval > 0.0 else dt
            else:  # the robot zeroes a command that is older than T
                self._push(self.period)
                self.speeds.fill(0.0)
                self._push(dt - self.period)
            self._tail *= math.exp(-dt / self.lag) if self.lag > 0.0 else 0.0
        self._weigh()
        return self.in_flight

    def command(self, twist: Array) -> None:
        """Record the twist (6,) [m/s, rad/s] that is sent now."""
        speeds, durations = self.speeds, self._durations
        # Of two at the same instant (a step that failed after its command, then the brake) either may be what acts.
        np.maximum(SENSES.dot(twist), speeds if self._just_sent else _NONE, out=speeds)
        self._just_sent = True
        # It may act early, in place of earlier ones, by the spread of the delay: at most T less a regular interval.
        row = self._first + len(durations)
        early = self.period - self._interval
        while early > _INSTANT and row > self._first:
            row -= 1
            acting = self._acting[row]
            np.maximum(acting, speeds, out=acting)
            early -= durations[row - self._first]

    def _push(self, duration: float) -> None:
        durations = self._durations
        row = self._first + len(durations)
        if row == _ROWS:
            row = self._compact()
        self._just_sent = False
        self._sent[row] = self.speeds
        largest, acting = self.speeds, self._acting[row]
        # An earlier command may still act, as long as it is not older than T.
        age, earlier = 0.0, row
        while earlier > self._first:
            earlier -= 1
            age += durations[earlier - self._first]
            if age > self.period - _INSTANT:
                break
            largest = np.maximum(largest, self._sent[earlier], out=acting)
        if largest is self.speeds:
            acting[:] = largest
        durations.append(duration)
        if len(durations) > _MOST_SEGMENTS:
            self._merge_oldest()

    def _compact(self) -> int:
        count = len(self._durations) + 1
        for rows in (self._sent, self._acting):
            rows[:count] = rows[self._first - 1 : self._first - 1 + count].copy()
        self._first = 1
        return count

    def _merge_oldest(self) -> None:
        """Count the two oldest segments as one in which the larger of both acted."""
        first = self._first
        for rows in (self._sent, self._acting):
            np.maximum(rows[first], rows[first + 1], out=rows[first + 1])
        self._acting[first] = self._acting[first - 1]
        oldest = self._durations.pop(0)
        self._durations[0] += oldest
        self._first += 1

    def _weigh(self) -> None:
        """``s = sum over segments of speed * integral of the share that is still to act``."""
        d, tau, durations = self.delay, self.lag, self._durations
        keep = d if d > self.period else self.period
        weights = [self._tail, *durations]
        row, age, old = len(durations), 0.0, 0
        while row and age + weights[row] <= d:  # still to act in full
            age += weights[row]
            row -= 1
        passed = age
        while row:
            if age >= keep:
                old += 1
            age += weights[row]
            # Integral of the share from age 0: 1 up to d, exp(-(a - d)/tau) beyond.
            until = d + tau * (1.0 - math.exp((d - age) / tau)) if tau > 0.0 else d
            weights[row] = until - passed
            passed = until
            row -= 1
        acting = self._acting[self._first - 1 : self._first + len(durations)]
        if old > _OLD_SEGMENTS:  # acted but for the lag, whose exponential the tail continues exactly
            acting[old] = np.dot(weights[: old + 1], acting[: old + 1])
            del durations[:old], weights[:old]
            acting, self._first = acting[old:], self._first + old
            weights[0] = self._tail = 1.0
        np.array(weights).dot(acting, self.in_flight)
