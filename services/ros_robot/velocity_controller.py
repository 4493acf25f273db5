"""A group velocity controller, as those of ROS 1 and ROS 2 behave: it holds the last command without end."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from services.ros_robot.messages import Velocities
from shared.spatial import Array


class GroupVelocityController:
    """Turns velocities into set-points.

    Attributes:
        name: of the controller.
        joints: that it moves.
        running: whether it moves them; to start it clears what was commanded before.

    Args:
        name, joints: see above.
        lower, upper, speed: limits of the joints' positions [rad, m] and speeds [rad/s, m/s], (n,) each.
    """

    def __init__(self, name: str, joints: Sequence[str], lower: Array, upper: Array, speed: Array) -> None:
        self.name = name
        self.joints = tuple(joints)
        self.running = False
        self._lower, self._upper, self._speed = lower, upper, speed
        self.hold(np.clip(np.zeros(len(self.joints)), lower, upper))

    def hold(self, position: Array) -> None:
        """Forget the command, and stand still at positions (n,) [rad, m]."""
        self._position = np.array(position, dtype=float)
        self._velocity = np.zeros(len(self.joints))

    def command(self, message: Velocities) -> str:
        """Move at velocities until others come.

        Returns:
            Why they are refused; empty if they are taken. What was commanded before goes on then.
        """
        if not self.running:
            return f"{self.name} is not running"
        if len(message.values) != len(self.joints) or not np.isfinite(message.values).all():
            return f"{self.name} wants {len(self.joints)} finite numbers, got {len(message.values)}"
        self._velocity = np.clip(np.asarray(message.values, dtype=float), -self._speed, self._speed)
        return ""

    def advance(self, dt: float) -> tuple[Array, Array]:
        """Set-points after ``dt`` [s] more: positions (n,) [rad, m] and velocities (n,)."""
        before = self._position
        self._position = np.clip(before + self._velocity * dt, self._lower, self._upper)
        return self._position, (self._position - before) / dt
