"""The base service in one process with a made-up robot, wrench service and task, under simulated time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from services.base.base import Base
from services.base.parameters import BaseParameters
from shared.clock import nanoseconds
from shared.loop.stack import Stack
from shared.messages import BaseStatus, BaseTwistCommand, Enable, EndEffector, ExternalWrench, RobotStatus
from shared.spatial import Array
from shared.topics import (
    BASE_ENABLE,
    BASE_PARAMETERS,
    BASE_STATUS,
    COMMAND_BASE_TWIST,
    STATE_EE,
    STATE_ROBOT,
    WRENCH_EXTERNAL,
    Topic,
)
from shared.wire.client import Client
from shared.wire.subscription import Received

PERIOD = 0.01
EXACT: dict[str, Any] = {"dead_band_force": 0.0, "dead_band_torque": 0.0}
"""Parameters without a dead band, for comparison with the closed form."""
TOOL = (0.6, -0.2, 1.0)


class Rig:
    """Publishes what the base needs; everything can be changed at any time. ``period`` [s] is asked for each wrench."""

    def __init__(self, base_type: str = "omni", **parameters: Any) -> None:
        self.stack = Stack()
        self._robot = Client(self.stack.bus, self.stack.scheduler.clock)
        self.wrench: Array = np.zeros(6)
        self.error: Array = np.zeros(6)
        self.wrench_on = self.robot_on = self.status_on = self.enable_on = True
        self.wrench_valid = self.enable_valid = self.enabled = True
        self.wrench_fault = ""
        self.period: Callable[[], float] = lambda: PERIOD
        self.position: tuple[float, ...] = TOOL
        self.base_type, self.mode, self.max_base = base_type, "ready", (1.0, 1.0, 2.0)
        self.commands: list[Received[BaseTwistCommand]] = []
        self.statuses: list[Received[BaseStatus]] = []
        self.stack.client.watch(COMMAND_BASE_TWIST, self.commands.append)
        self.stack.client.watch(BASE_STATUS, self.statuses.append)
        self.base = Base(BaseParameters.of(parameters))
        self.runner = self.stack.add(self.base)
        for action in (self._say_pose, self._say_status, self._enable, self._feel):
            self.stack.scheduler.soon(action)

    def _say_pose(self) -> None:
        if self.robot_on:
            zero = np.zeros(3)
            self._robot.publish(STATE_EE, EndEffector(self.position, (0, 0, 0, 1), zero, zero))
        self._again(PERIOD, self._say_pose)

    def _say_status(self) -> None:
        if self.robot_on and self.status_on:
            self.say_robot()
        self._again(0.2, self._say_status)

    def say_robot(self) -> None:
        """``state/robot``, as on a change."""
        status = RobotStatus(self.mode, "by hand", self.base_type, False, 0.3, 1.0, self.max_base)
        self._robot.publish(STATE_ROBOT, status)

    def _enable(self) -> None:
        if self.enable_on:
            self.publish(BASE_ENABLE, Enable(self.enabled), self.enable_valid)
        self._again(0.2, self._enable)

    def _feel(self) -> None:
        if self.wrench_on:
            message = ExternalWrench(self.wrench[:3], self.wrench[3:], self.error, "tare", self.wrench_fault)
            self.publish(WRENCH_EXTERNAL, message, self.wrench_valid)
        self._again(self.period(), self._feel)

    def _again(self, after: float, call: Callable[[], None]) -> None:
        self.stack.scheduler.at(self.stack.scheduler.clock.now_ns() + nanoseconds(after), call)

    def publish(self, topic: Topic, message: Any, valid: bool = True) -> None:
        self.stack.client.publish(topic, message, valid)

    def run(self, duration: float) -> None:
        """Let time pass; keeps what was published meanwhile."""
        self.commands.clear()
        self.statuses.clear()
        self.stack.run(duration)

    def started(self) -> Rig:
        """Healthy for long enough, enabled and at rest."""
        self.run(1.0)
        assert self.status.state == "following" and self.resting
        return self

    def pushed(self, force: float = 8.0, duration: float = 1.0) -> Rig:
        """Started, then pushed forwards [N] for a while."""
        self.started()
        self.push(fx=force)
        self.run(duration)
        assert self.velocity[0] > 0.0
        return self

    def push(self, fx: float = 0.0, fy: float = 0.0, tz: float = 0.0) -> None:
        """A wrench at the tool [N, N, Nm]."""
        self.wrench = np.array((fx, fy, 0.0, 0.0, 0.0, tz))

    def enable(self, enabled: bool) -> None:
        """Enable or disable now and from now on."""
        self.enabled = enabled
        self.publish(BASE_ENABLE, Enable(enabled), self.enable_valid)

    def restart_robot(self, silence: float) -> None:
        """The robot falls silent [s] and comes back in a new session; its sensor with it."""
        self.robot_on = self.wrench_on = False
        self.run(silence)
        self._robot = Client(self.stack.bus, self.stack.scheduler.clock)
        self.robot_on = self.wrench_on = True

    @property
    def velocities(self) -> Array:
        """All commands (n, 3) since the last call of ``run``."""
        return np.array([received.message.velocity for received in self.commands])

    @property
    def velocity(self) -> Array:
        """The newest command (3,)."""
        return self.commands[-1].message.velocity

    @property
    def resting(self) -> bool:
        """Whether nothing but zero was commanded since the last call of ``run``."""
        return not self.velocities.any()

    @property
    def status(self) -> BaseStatus:
        """The newest status."""
        return self.statuses[-1].message

    def ask(self, **values: Any) -> dict[str, Any]:
        """Read, or set, parameters."""
        return self.stack.client.ask(BASE_PARAMETERS, {"set": values} if values else {})
