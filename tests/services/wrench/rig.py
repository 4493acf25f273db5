"""The wrench service in one process with a made-up sensor, under simulated time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from services.wrench.parameters import WrenchParameters
from services.wrench.wrench import Wrench
from shared.clock import nanoseconds
from shared.loop.stack import Stack
from shared.messages import ExternalWrench, FtSample
from shared.spatial import Array
from shared.topics import SENSOR_FT, WRENCH_EXTERNAL, WRENCH_IDENTIFY, Query
from shared.wire.subscription import Received
from tests.services.wrench.sensor import LEVEL, TILTED, Sensor

BAG = np.array((0.0, 0.0, -20.0, 1.0, -2.0, 0.0))


class Rig:
    """Publishes a sample of the sensor every period; what it feels and how it stands can be changed at any time."""

    def __init__(self, folder: Path | None = None, rate: float = 100.0, **parameters: Any) -> None:
        self.stack = Stack()
        self.sensor = Sensor()
        self.rotation: Array = LEVEL
        self.external: Array = np.zeros(6)
        self.saturated = False
        self.stuck: list[int] = []
        self.on = True
        self.valid = True
        self.turning: Array | None = None
        self.received: list[Received[ExternalWrench]] = []
        self.subscription = self.stack.client.watch(WRENCH_EXTERNAL, self.received.append)
        self.wrench = Wrench(WrenchParameters.of(parameters), folder)
        self.runner = self.stack.add(self.wrench)
        self._period = nanoseconds(1 / rate)
        self._sample: FtSample | None = None
        self.stack.scheduler.soon(self._tick)

    def _tick(self) -> None:
        if self.on:
            sample = self.sensor.sample(self.rotation, self.external, self.saturated)
            if self.stuck and self._sample is not None:
                values = np.concatenate((sample.force, sample.torque))
                values[self.stuck] = np.concatenate((self._sample.force, self._sample.torque))[self.stuck]
                sample = FtSample(
                    values[:3], values[3:], sample.orientation, sample.tool_offset, self.saturated
                )
            self._sample = sample
            self.stack.client.publish(SENSOR_FT, sample, self.valid)
            if self.turning is not None:
                self.rotation = self.turning @ self.rotation
        self.stack.scheduler.at(self.stack.scheduler.clock.now_ns() + self._period, self._tick)

    @property
    def last(self) -> Received[ExternalWrench]:
        return self.received[-1]

    @property
    def wrenches(self) -> Array:
        """Every wrench (n, 6) since the last call of ``run``."""
        return np.array([np.concatenate((r.message.force, r.message.torque)) for r in self.received])

    def run(self, duration: float) -> list[Received[ExternalWrench]]:
        """Let time pass; what was published meanwhile."""
        self.received.clear()
        self.stack.run(duration)
        return list(self.received)

    def ask(self, query: Query, **request: Any) -> dict[str, Any]:
        return self.stack.client.ask(query, request, timeout=40.0)


def bounds_hold(rig: Rig, external: np.ndarray) -> bool:
    bounds = np.array([r.message.error_bound for r in rig.received])
    return bool(np.all(np.abs(rig.wrenches - external) <= bounds))


def identified(rig: Rig) -> dict:
    rig.ask(WRENCH_IDENTIFY, action="start")
    for rotation in TILTED:
        rig.rotation = rotation
        rig.run(0.05)
        rig.ask(WRENCH_IDENTIFY, action="add")
    return rig.ask(WRENCH_IDENTIFY, action="solve")
