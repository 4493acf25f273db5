"""A stack without physics, heard by a recording that gets everything late and in another order."""

from __future__ import annotations

import random
from pathlib import Path

import numpy as np

from services.base.base import Base
from services.base.parameters import BaseParameters
from services.controller.controller import Controller
from services.controller.parameters import ControllerParameters
from services.mock.parameters import MockParameters
from services.mock.robot import MockRobot
from services.recorder.topics import everything
from services.task.parameters import TaskParameters
from services.task.task import Task
from services.wrench.parameters import WrenchParameters
from services.wrench.wrench import Wrench
from shared import topics
from shared.clock import nanoseconds
from shared.loop.stack import Stack
from shared.messages import ControlTarget, Stop
from shared.wire.log import Heard, write_log

LATEST = nanoseconds(0.03)  # [ns] that the recording hears something late at most
TARGET = ControlTarget(np.array([0.5, -0.3, 1.0]), np.array([0.0, 0.0, 0.0, 1.0]), np.full(3, 25.0), np.full(3, 10.0))


class Recorded:
    """Five seconds in which a person tares, holds, pushes, sets a parameter, stops and resumes."""

    def __init__(self, folder: Path) -> None:
        self.heard: list[Heard] = []
        late = random.Random(5)
        stack = self.stack = Stack(latency=0.0005)
        robot = MockRobot(MockParameters())
        for topic in everything(camera=False):
            stack.bus.subscribe(topic.key, self._listener(topic.key, late))
        for service in (
            robot,
            Wrench(WrenchParameters(), folder),
            Controller(ControllerParameters.of({"law": "certified", "max_linear": 0.1})),
            Base(BaseParameters()),
            Task(TaskParameters(), lambda: stack.now, folder),
        ):
            stack.add(service)
        stack.run(1.0)
        stack.client.ask(topics.WRENCH_TARE, {"duration": 0.5})
        for second, force in enumerate((0.0, 30.0, 0.0, 10.0)):
            robot.sensors.wrench = np.array([force, 0.0, 0.0, 0.0, 0.0, 0.0])
            for _ in range(5):
                stack.client.publish(topics.CONTROL_TARGET, TARGET)
                stack.run(0.2)
            if second == 1:
                stack.client.ask(topics.CONTROL_PARAMETERS, {"set": {"max_linear": 0.2}})
            if second == 2:
                stack.client.publish(topics.STOP, Stop(True, "a person"))
                stack.run(0.1)
                stack.client.publish(topics.STOP, Stop(False))

    def _listener(self, key: str, late: random.Random):  # type: ignore[no-untyped-def]
        def take(payload: bytes) -> None:
            # But for who is there, which tokens say at once.
            delay = 0 if key.startswith("setup/") else late.randrange(LATEST)
            arrival = self.stack.scheduler.clock.now_ns() + delay
            self.heard.append(Heard(key, arrival, bytes(payload)))

        return take

    def file(self, path: Path, heard: list[Heard] | None = None) -> Path:
        """A recording of all, or of some."""
        write_log(path, {"robot": "tiago"}, self.heard if heard is None else heard)
        return path
