"""Accounting for the time of a service loop."""

from __future__ import annotations

from collections import deque

from shared import faults
from shared.clock import Clock
from shared.faults import Fault

_WINDOW_NS = 1_000_000_000
_FEWEST_STEPS = 20
"""Below this many steps in the window (20 Hz) a share of late ones says nothing; a stall is seen at any rate."""


class LoopTiming:
    """Latencies and overruns of the last second's steps, and the overruns since the start."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._steps: deque[tuple[int, int, bool]] = deque()
        self._late = 0
        self.overruns = 0

    def add(self, latency_ns: int, late: bool) -> None:
        """Account for a step: latency [ns] from its cause to its outputs, and whether it was late."""
        now = self._clock.now_ns()
        self._steps.append((now, latency_ns, late))
        self._late += late
        self.overruns += late
        self._trim(now)

    def _trim(self, now: int) -> None:
        while self._steps and now - self._steps[0][0] > _WINDOW_NS:
            self._late -= self._steps.popleft()[2]

    def fault(self, now: int, share_limit: float) -> Fault | None:
        """Why the loop cannot be trusted at present, or None."""
        self._trim(now)
        steps = len(self._steps)
        if steps >= _FEWEST_STEPS and self._late > share_limit * steps:
            return faults.overrun(self._late, steps, share_limit)
        return None

    def summary(self, now: int) -> tuple[float, float, float]:
        """Rate [Hz], median and 99th percentile [us] of the latency over the last second."""
        self._trim(now)
        if not self._steps:
            return 0.0, 0.0, 0.0
        latencies = sorted(latency for _, latency, _ in self._steps)
        count = len(latencies)
        return float(count), latencies[count // 2] * 1e-3, latencies[min(count - 1, count * 99 // 100)] * 1e-3
