"""The task on a stack of its own with a robot: lead it to where a test begins, silence it, kill the task."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from services.task.geometry import Pose
from services.task.parameters import TaskParameters
from services.task.task import Task
from shared.clock import nanoseconds
from shared.loop.stack import Stack
from shared.topics import CONTROL_TARGET, SENSOR_CAMERA, TASK_COMMAND, health_topic
from shared.wire.client import Client
from tests.services.task.robot import TICK, Robot


class Rig:
    """A stack with the task, and a robot on it; the task can be killed and started again."""

    def __init__(self, folder: Path | None = None, **parameters: Any) -> None:
        self.stack = Stack()
        self.folder = folder
        self.settings = TaskParameters.of(parameters)
        self.robot = Robot(self.stack.client.watch, self.settings)
        self.publisher = Client(self.stack.bus, self.stack.scheduler.clock)
        self.health = self.stack.client.watch(health_topic("task"))
        self.leads = True
        self.lag = 0.0
        """Time [s] since the images were taken that the camera sends now."""
        self._ticks = 0
        self.start_task()
        self.stack.scheduler.soon(self._tick)

    def start_task(self) -> None:
        self.task = Task(self.settings, lambda: self.stack.now, self.folder)
        self.runner = self.stack.add(self.task)

    def kill_task(self) -> None:
        """As SIGKILL does: it says nothing any more."""
        self.runner.poll = lambda behind=False: None  # type: ignore[method-assign]
        self.runner.next_deadline = lambda: 2**62  # type: ignore[method-assign]
        self.stack.bus._servers.pop(TASK_COMMAND.key, None)

    def restart_robot(self) -> None:
        self.publisher = Client(self.stack.bus, self.stack.scheduler.clock)

    def _tick(self) -> None:
        if self.leads:
            self.robot.person()
        for topic, message, valid in self.robot.tick(self._ticks):
            taken = self.stack.scheduler.clock.now_ns() - nanoseconds(
                self.lag if topic is SENSOR_CAMERA else 0.0
            )
            self.publisher.publish(topic, message, valid, taken)
        self._ticks += 1
        self.stack.scheduler.at(self.stack.scheduler.clock.now_ns() + nanoseconds(TICK), self._tick)

    def ask(self, command: str) -> str:
        return self.stack.client.ask(TASK_COMMAND, {"command": command})["state"]

    def until(self, state: str, within: float = 60.0) -> Rig:
        self.stack.run(within, lambda: self.robot.state == state)
        assert self.robot.state == state, f"{self.robot.state}: {self.robot.reason}"
        return self

    def run(self, duration: float) -> Rig:
        self.stack.run(duration)
        return self

    def begun(self) -> Rig:
        self.run(1.0)
        self.ask("start")
        return self

    def carrying(self) -> Rig:
        self.begun().until("carrying")
        self.leads = False
        self.robot.toy.lifted = True
        return self.run(2.0)

    @property
    def target(self) -> Pose:
        message = self.robot.last(CONTROL_TARGET)
        return Pose.of(message.position, message.orientation)
