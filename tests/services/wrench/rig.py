"""The wrench service in one process with a made-up sensor, under simulated time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from services.wrench.parameters import WrenchParameters
from services.wrench.wrench import Wrench
from shared.messages import FtSample
from shared.spatial import Array
from shared.topics import SENSOR_FT, WRENCH_EXTERNAL, WRENCH_IDENTIFY, WRENCH_TARE
from shared.wire.subscription import Received
from tests.services.wrench.sensor import LEVEL, TILTED, Sensor
from tests.support.service_rig import ServiceRig

BAG = np.array((0.0, 0.0, -20.0, 1.0, -2.0, 0.0))


class Rig(ServiceRig):
    """Publishes a sample of the sensor every period; what it feels and how it stands can be changed at any time."""

    def __init__(self, folder: Path | None = None, rate: float = 100.0, **parameters: Any) -> None:
        super().__init__()
        self.sensor = Sensor()
        self.rotation: Array = LEVEL
        self.external: Array = np.zeros(6)
        self.saturated = False
        self.stuck: list[int] = []
        self.on = self.valid = True
        self.turning: Array | None = None
        self.received = self.hear(WRENCH_EXTERNAL)
        self.wrench = Wrench(WrenchParameters.of(parameters), folder)
        self.runner = self.stack.add(self.wrench)
        self._sample: FtSample | None = None
        self.every(lambda: 1 / rate, self._tick)

    def _tick(self) -> None:
        if not self.on:
            return
        sample = self.sensor.sample(self.rotation, self.external, self.saturated)
        if self.stuck and self._sample is not None:
            values = np.concatenate((sample.force, sample.torque))
            values[self.stuck] = np.concatenate((self._sample.force, self._sample.torque))[self.stuck]
            sample = sample.replaced(force=values[:3], torque=values[3:])
        self._sample = sample
        self.surroundings.publish(SENSOR_FT, sample, self.valid)
        if self.turning is not None:
            self.rotation = self.turning @ self.rotation

    @property
    def last(self) -> Received:
        return self.received[-1]

    @property
    def wrenches(self) -> Array:
        """Every wrench (n, 6) since the last call of ``run``."""
        return np.array([np.concatenate((r.message.force, r.message.torque)) for r in self.received])

    def settle(self, duration: float) -> list[Received]:
        """Let time pass after a change that the sample under way has not seen; what was published meanwhile."""
        self.run(0.02)
        return self.heard(duration)

    def heard(self, duration: float) -> list[Received]:
        """Let time pass; what was published meanwhile."""
        self.run(duration)
        return list(self.received)

    def tare(self) -> dict[str, Any]:
        return self.ask(WRENCH_TARE, {"duration": 1.0})

    def identify(self, action: str) -> dict[str, Any]:
        return self.ask(WRENCH_IDENTIFY, {"action": action})


def bounds_hold(rig: Rig, external: np.ndarray) -> bool:
    bounds = np.array([r.message.error_bound for r in rig.received])
    return bool(np.all(np.abs(rig.wrenches - external) <= bounds))


def identified(rig: Rig) -> dict:
    rig.identify("start")
    for rotation in TILTED:
        rig.rotation = rotation
        rig.run(0.05)
        rig.identify("add")
    return rig.identify("solve")
