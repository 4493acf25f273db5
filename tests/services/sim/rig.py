"""The simulator in simulated time, with somebody who commands and listens."""

from __future__ import annotations

from typing import Any

import numpy as np

from services.sim.parameters import SimParameters
from services.sim.simulator import Simulator
from shared import topics
from shared.clock import nanoseconds
from shared.loop.stack import Stack
from shared.messages import BaseTwistCommand, GripperCommand, TwistCommand
from shared.topics import Topic
from shared.wire.subscription import Received


class Rig:
    """A simulator on a bus of its own, by default of the bare robot; all that it publishes is collected per topic."""

    def __init__(self, **parameters: Any) -> None:
        self.stack = Stack()
        self.simulator = Simulator(SimParameters.of({"scene": "load"} | parameters))
        self.runner = self.stack.add(self.simulator)
        self.received: dict[str, list[Received]] = {}
        for topic in (*topics.TOPICS, topics.health_topic("sim")):
            self.received[topic.key] = []
            self.stack.client.watch(topic, self.received[topic.key].append)
        self.run(0.1)

    def run(self, duration: float) -> None:
        self.stack.run(duration)

    def last(self, topic: Topic) -> Any:
        return self.received[topic.key][-1].message

    def all(self, topic: Topic) -> list[Any]:
        return [received.message for received in self.received[topic.key]]

    def ask(self, **request: Any) -> dict[str, Any]:
        return self.stack.client.ask(topics.SIM_COMMAND, request)

    def move(self, linear: tuple[float, ...], duration: float, angular: tuple[float, ...] = (0, 0, 0)) -> None:
        """Command a twist at 100 Hz with a ttl of 20 ms."""
        end = self.stack.now + duration
        while self.stack.now < end - 1e-9:
            self.stack.client.publish(topics.COMMAND_EE_TWIST, TwistCommand(linear, angular, 0.02))
            self.stack.scheduler.run_until(self.stack.scheduler.clock.now_ns() + nanoseconds(0.01))

    def drive(self, velocity: tuple[float, float, float], duration: float) -> None:
        """Command a velocity of the base at 100 Hz."""
        for _ in range(round(duration / 0.01)):
            self.stack.client.publish(topics.COMMAND_BASE_TWIST, BaseTwistCommand(velocity, 0.1))
            self.stack.scheduler.run_until(self.stack.scheduler.clock.now_ns() + nanoseconds(0.01))

    def grasp(self) -> None:
        """Open, drive the fingers over the panel's edge, and close."""
        self.stack.client.publish(topics.COMMAND_GRIPPER, GripperCommand(0.09, 16.0))
        self.run(1.2)
        self.move((0.05, 0, 0), 1.8)
        self.stack.client.publish(topics.COMMAND_GRIPPER, GripperCommand(0.0, 16.0))
        self.run(2.0)

    @property
    def reading(self) -> np.ndarray:
        """Newest wrench (6,) [N, Nm] that the wrist sensor reads, in its axes."""
        sample = self.last(topics.SENSOR_FT)
        return np.concatenate((sample.force, sample.torque))

    @property
    def height(self) -> float:
        return float(self.last(topics.STATE_EE).position[2])

    @property
    def speed(self) -> float:
        return float(np.linalg.norm(self.last(topics.STATE_EE).linear))
