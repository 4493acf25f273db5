"""The controller in one process with a made-up robot and wrench service, under simulated time."""

from __future__ import annotations

from typing import Any

import numpy as np

from services.controller.controller import Controller
from services.controller.parameters import ControllerParameters
from shared.clock import nanoseconds
from shared.loop.stack import Stack
from shared.messages import ControlTarget, EndEffector, ExternalWrench
from shared.spatial import Array, quaternion, rotation_from_vector
from shared.topics import (
    COMMAND_EE_TWIST,
    CONTROL_PARAMETERS,
    CONTROL_STATUS,
    CONTROL_TARGET,
    STATE_EE,
    WRENCH_EXTERNAL,
    Topic,
)
from shared.wire.client import Client
from shared.wire.subscription import Received

PERIOD = 0.01
ERROR = np.array((0.2, 0.2, 0.2, 0.02, 0.02, 0.02))
HOME = np.array((0.5, -0.3, 1.0))


class Rig:
    """Publishes wrench and pose every period and executes what is commanded; everything can be changed at any time."""

    def __init__(self, **parameters: Any) -> None:
        self.stack = Stack()
        self._robot = Client(self.stack.bus, self.stack.scheduler.clock)
        self.wrench: Array = np.zeros(6)
        self.error: Array = ERROR
        self.wrench_on = self.ee_on = self.wrench_valid = True
        self.wrench_fault = ""
        self.wrench_period = PERIOD
        self.position: Array = HOME.copy()
        self.rotation: Array = np.eye(3)
        self.commands: list[Received] = []
        self.statuses: list[Received] = []
        self.stack.client.watch(COMMAND_EE_TWIST, self.commands.append)
        self.stack.client.watch(CONTROL_STATUS, self.statuses.append)
        self.controller = Controller(ControllerParameters.of(parameters))
        self.runner = self.stack.add(self.controller)
        self.stack.scheduler.soon(self._move)
        self.stack.scheduler.soon(self._feel)

    def _move(self) -> None:
        twist = self.twist if self.commands and self.command_age < 0.02 else np.zeros(6)
        self.position = self.position + PERIOD * twist[:3]
        self.rotation = rotation_from_vector(PERIOD * twist[3:]) @ self.rotation
        if self.ee_on:
            pose = EndEffector(self.position, quaternion(self.rotation), twist[:3], twist[3:])
            self._robot.publish(STATE_EE, pose)
        self._again(PERIOD, self._move)

    def _feel(self) -> None:
        if self.wrench_on:
            message = ExternalWrench(self.wrench[:3], self.wrench[3:], self.error, "tare", self.wrench_fault)
            self.publish(WRENCH_EXTERNAL, message, self.wrench_valid)
        self._again(self.wrench_period, self._feel)

    def _again(self, after: float, call: Any) -> None:
        self.stack.scheduler.at(self.stack.scheduler.clock.now_ns() + nanoseconds(after), call)

    def publish(self, topic: Topic, message: Any, valid: bool = True) -> None:
        self.stack.client.publish(topic, message, valid)

    def target(self, offset: Any = (0.0, 0.0, 0.0), force: float = 10.0, torque: float = 3.0, **more: Any) -> None:
        """Wish for a pose beside home, with limits on force [N] and torque [Nm]."""
        self.publish(
            CONTROL_TARGET, ControlTarget(HOME + np.array(offset), (0, 0, 0, 1), (force,) * 3, (torque,) * 3, **more)
        )

    def run(self, duration: float) -> None:
        """Let time pass; keeps what was published meanwhile, in which no state may deny that the tool moves."""
        self.commands.clear()
        self.statuses.clear()
        self.stack.run(duration)
        for status in (received.message for received in self.statuses):
            assert status.state in ("tracking", "yielding") or not status.twist.any()

    def restart_robot(self, silence: float, position: Any = HOME) -> None:
        """The robot falls silent [s] and comes back elsewhere in a new session; its sensor with it."""
        self.ee_on = self.wrench_on = False
        self.run(silence)
        self._robot = Client(self.stack.bus, self.stack.scheduler.clock)
        self.position = np.array(position)
        self.ee_on = self.wrench_on = True

    def started(self, **target: Any) -> Rig:
        """Healthy for long enough, with a target."""
        self.target(**target)
        self.run(1.0)
        return self

    @property
    def twist(self) -> Array:
        """The newest command (6,)."""
        message = self.commands[-1].message
        return np.concatenate((message.linear, message.angular))

    @property
    def twists(self) -> Array:
        """All commands (n, 6) since the last call of ``run``."""
        return np.array([np.concatenate((r.message.linear, r.message.angular)) for r in self.commands])

    @property
    def resting(self) -> bool:
        """Whether nothing but zero was commanded since the last call of ``run``."""
        return not self.twists.any()

    @property
    def command_age(self) -> float:
        """Age [s] of the newest command."""
        return (self.stack.scheduler.clock.now_ns() - self.commands[-1].arrival_ns) * 1e-9

    @property
    def status(self) -> Any:
        """The newest status."""
        return self.statuses[-1].message

    def ask(self, **values: Any) -> dict[str, Any]:
        """Read, or set, parameters."""
        return self.stack.client.ask(CONTROL_PARAMETERS, {"set": values} if values else {})
