"""Accounting for the time of a service loop, and the health message made of it."""

from __future__ import annotations

import math
from collections import deque
from typing import TYPE_CHECKING

from shared import faults
from shared.clock import Clock, nanoseconds, seconds
from shared.faults import Fault, FaultKind
from shared.messages import Health, InputHealth
from shared.topics import HEALTH_RATE, health_topic

if TYPE_CHECKING:
    from shared.loop.runner import Runner

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


class HealthReporter:
    """Publishes a runner's health at 2 Hz."""

    def __init__(self, runner: Runner) -> None:
        self._runner = runner
        self._topic = health_topic(runner.service.wiring.name)
        self.due = 0

    def send(self, now: int) -> None:
        """Publish the health as of now [ns]."""
        self.due = now + nanoseconds(1 / HEALTH_RATE)
        runner = self._runner
        loop_hz, p50, p99 = runner.timing.summary(now)
        fault, notes = runner.fault, runner.service.notes()
        if fault is None:
            state, detail = ("degraded", notes) if notes else ("ok", "")
        elif fault.waiting:
            state, detail = "starting", fault.text
        else:
            state, detail = ("fault" if fault.kind is FaultKind.INTERNAL else "degraded"), fault.text
        required = {topic.key for topic in runner.service.wiring.required}
        inputs = {}
        for key, inlet in runner.inlets.items():
            latest = inlet.latest
            # What may be missing, and what holds until it is replaced, has no fault by being silent.
            judged = key in required or (latest is not None and inlet.topic.max_age < math.inf)
            inputs[key] = InputHealth(
                age=-1.0 if latest is None else seconds(now - latest.arrival_ns) + latest.delay,
                hz=inlet.rate(now),
                rejected=inlet.rejected + inlet.out_of_order + inlet.second_session,
                ok=not judged or inlet.fault(now, runner.service.max_delay) is None,
            )
        runner.publish(
            self._topic,
            Health(state, detail, loop_hz, p50, p99, runner.timing.overruns, inputs),
            valid=fault is None,
        )
