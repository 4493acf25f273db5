"""The robot's side of the contract in a process that ticks, with somebody who commands it."""

from __future__ import annotations

import numpy as np

from shared.messages import Header, RobotStatus, TwistCommand
from shared.robot.base_gate import BaseLimits
from shared.robot.gate import GateLimits
from shared.robot.side import RobotSide
from shared.schema.records import Record
from shared.service import Inputs, Reading
from shared.topics import COMMAND_EE_TWIST, STATE_ROBOT, Topic

DT = 0.01
FORWARDS = (0.1, 0.0, 0.0)
ZERO = (0.0, 0.0, 0.0)


class Process:
    """A robot process that ticks at 100 Hz."""

    def __init__(self, require_enable: bool = False) -> None:
        self.side = RobotSide(
            GateLimits(0.3, 1.0, 1e3, 1e3),
            "omni",
            simulated=False,
            base=BaseLimits(0.5, 0.2, 0.4, 0.3, 1.0, 2.0),
            gripper={"opening": (0.0, 0.09), "effort": (0.0, 16.0)},
            head={"pan": (-1.3, 1.3), "tilt": (-1.0, 0.7)},
            require_enable=require_enable,
        )
        self.statuses: list[RobotStatus] = []
        self._readings: dict[str, Reading] = {}

    def send(self, topic: Topic, message: Record, valid: bool = True, age: float = 0.0) -> None:
        self._readings[topic.key] = Reading(message, Header(0, 1, 0, valid), age, True)

    def move(self, ttl: float = 0.1, age: float = 0.0) -> None:
        self.send(COMMAND_EE_TWIST, TwistCommand(FORWARDS, ZERO, ttl), age=age)

    def tick(self, refusals: dict[str, str] | None = None) -> np.ndarray:
        self.side.take(Inputs(self._readings, refusals or {}))
        self._readings = {
            key: Reading(reading.message, reading.header, reading.age + DT, False)
            for key, reading in self._readings.items()
        }
        twist = self.side.advance(DT)
        for output in self.side.report(DT, "the arm is short"):
            assert output.topic == STATE_ROBOT
            self.statuses.append(output.message)
        return twist

    def run(self, duration: float) -> None:
        for _ in range(round(duration / DT)):
            self.tick()
