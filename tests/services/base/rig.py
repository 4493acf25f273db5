"""The base service in one process with a made-up robot, wrench service and task, under simulated time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from services.base.base import Base
from services.base.parameters import BaseParameters
from shared import topics
from shared.messages import BaseStatus, Enable, EndEffector, ExternalWrench, RobotStatus, Stop
from shared.spatial import Array
from tests.support.service_rig import ServiceRig

PERIOD = 0.01
EXACT: dict[str, Any] = {"dead_band_force": 0.0, "dead_band_torque": 0.0}
"""Parameters without a dead band, for comparison with the closed form."""
TOOL = (0.6, -0.2, 1.0)


class Rig(ServiceRig):
    """Publishes what the base needs; everything can be changed at any time. ``period`` [s] is asked for each wrench."""

    def __init__(self, base_type: str = "omni", **parameters: Any) -> None:
        super().__init__()
        self.wrench: Array = np.zeros(6)
        self.error: Array = np.zeros(6)
        self.wrench_on = self.robot_on = self.status_on = self.enable_on = True
        self.wrench_valid = self.enable_valid = self.enabled = True
        self.wrench_fault = ""
        self.period: Callable[[], float] = lambda: PERIOD
        self.position: tuple[float, ...] = TOOL
        self.base_type, self.mode, self.max_base = base_type, "ready", (1.0, 1.0, 2.0)
        self.commands = self.hear(topics.COMMAND_BASE_TWIST)
        self.statuses = self.hear(topics.BASE_STATUS)
        self.base = Base(BaseParameters.of(parameters))
        self.runner = self.stack.add(self.base)
        self.every(lambda: PERIOD, self._say_pose)
        self.every(lambda: 0.2, self._say_status)
        self.every(lambda: 0.2, self._enable)
        self.every(lambda: self.period(), self._feel)

    def _say_pose(self) -> None:
        if self.robot_on:
            zero = np.zeros(3)
            pose = EndEffector(self.position, (0, 0, 0, 1), zero, zero)
            self.surroundings.publish(topics.STATE_EE, pose)

    def _say_status(self) -> None:
        if self.robot_on and self.status_on:
            self.say_robot()

    def say_robot(self, mode: str | None = None) -> None:
        """``state/robot``, as on a change; in another mode from now on, if one is given."""
        self.mode = mode or self.mode
        status = RobotStatus(self.mode, "by hand", self.base_type, False, 0.3, 1.0, self.max_base)
        self.surroundings.publish(topics.STATE_ROBOT, status)

    def _enable(self) -> None:
        if self.enable_on:
            self.publish(topics.BASE_ENABLE, Enable(self.enabled), self.enable_valid)

    def _feel(self) -> None:
        if self.wrench_on:
            message = ExternalWrench(self.wrench[:3], self.wrench[3:], self.error, "tare", self.wrench_fault)
            self.publish(topics.WRENCH_EXTERNAL, message, self.wrench_valid)

    def stop(self, engaged: bool, valid: bool = True) -> None:
        """Somebody stops everything, or releases that."""
        self.publish(topics.STOP, Stop(engaged, "red button"), valid)

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
        self.publish(topics.BASE_ENABLE, Enable(enabled), self.enable_valid)

    def restart_robot(self, silence: float) -> None:
        """The robot falls silent [s] and comes back in a new session; its sensor with it."""
        self.robot_on = self.wrench_on = False
        self.run(silence)
        self.new_session()
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

    def set(self, **values: Any) -> dict[str, Any]:
        """Set parameters; with none, read them."""
        return self.ask(topics.BASE_PARAMETERS, {"set": values} if values else {})["parameters"]
