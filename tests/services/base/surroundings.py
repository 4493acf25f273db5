"""Robot, wrench service and task in one, around a base service that runs as a process."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from shared.clock import SteadyClock
from shared.messages import BaseStatus, Enable, EndEffector, ExternalWrench, RobotStatus
from shared.topics import (
    BASE_ENABLE,
    BASE_STATUS,
    COMMAND_BASE_TWIST,
    STATE_EE,
    STATE_ROBOT,
    WRENCH_EXTERNAL,
)
from tests.support.stand_in import StandIn


class Surroundings(StandIn):
    """Robot, wrench service and task in one; collects what the base says.

    Attributes:
        last_sound_ns: when the last wrench left that is to be used.
    """

    def __init__(self, endpoint: str) -> None:
        super().__init__(endpoint, "base")
        self.valid, self.fault, self.enabled = True, "", True
        self.commands = self.hear(COMMAND_BASE_TWIST)
        self.statuses = self.hear(BASE_STATUS)
        self.last_sound_ns = 0

    def turn(self, number: int) -> None:
        zero, valid = np.zeros(3), self.valid
        self.client.publish(STATE_EE, EndEffector((0.5, 0.0, 1.0), (0, 0, 0, 1), zero, zero))
        wrench = ExternalWrench((6.0, 0.0, -7.0), zero, (0.2,) * 6, "tare", self.fault)
        self.client.publish(WRENCH_EXTERNAL, wrench, valid)
        if valid:
            self.last_sound_ns = self.bus.last_sent_ns[WRENCH_EXTERNAL.key]
        if number % 20 == 0:
            robot = RobotStatus("ready", "", "omni", False, 0.3, 1.0, (1.0, 1.0, 2.0))
            self.client.publish(STATE_ROBOT, robot)
            self.client.publish(BASE_ENABLE, Enable(self.enabled))

    @property
    def status(self) -> BaseStatus | None:
        return self.statuses[-1].message if self.statuses else None

    @property
    def detail(self) -> str:
        """What the health says."""
        return self.health.latest.message.detail if self.health.latest else ""

    def moving(self) -> bool:
        """Whether the newest command is fresh, valid and moves with the force."""
        if not self.commands:
            return False
        last = self.commands[-1]
        fresh = SteadyClock().now_ns() - last.arrival_ns < 100_000_000
        return fresh and last.header.valid and last.message.velocity[0] > 0.05

    def resting(self) -> bool:
        """Whether the newest command is zero."""
        return bool(self.commands) and not self.commands[-1].message.velocity.any()

    def braked(self, *parts: str) -> Callable[[], bool]:
        """Whether the base has come to rest, braking for a reason with these parts."""
        return lambda: (
            self.status is not None
            and self.status.state == "braking"
            and self.resting()
            and all(part in self.detail for part in parts)
        )

    def unharmed(self) -> None:
        """Nothing was commanded beyond the limits, and nothing sped up in a jump."""
        velocities = np.array([received.message.velocity for received in self.commands])
        assert np.isfinite(velocities).all() and np.linalg.norm(velocities[:, :2], axis=1).max() <= 0.4 + 1e-9
        assert np.diff(velocities[:, 0]).max() <= 0.7 * 0.1 + 1e-9
