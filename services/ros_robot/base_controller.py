"""The mobile base's own controller: it goes as told within its limits, and halts when it is told nothing."""

from __future__ import annotations

import math

import numpy as np

from shared.robot.base_gate import BaseLimits
from shared.spatial import Array

COMMAND_TIMEOUT = 0.25
"""[s] ``cmd_vel_timeout`` of both of a TIAGo's bases."""


class BaseController:
    """Turns commands into the velocity of the base.

    Args:
        limits: of the base.
    """

    def __init__(self, limits: BaseLimits) -> None:
        self._limits = limits
        self._wanted = np.zeros(3)
        self._velocity = np.zeros(3)
        self._until = -math.inf

    def command(self, velocity: Array, now: float, stamp: float | None = None) -> str:
        """Go at a velocity (3,) vx, vy [m/s], wz [rad/s].

        Args:
            velocity: see above; a way that the base cannot go is left out.
            now: time [s] of arrival.
            stamp: time [s] of a stamped command, which acts for so long from then on.

        Returns:
            Why it is refused; empty if it is taken.
        """
        if not np.isfinite(velocity).all():
            return "a velocity that is no number"
        since = now if stamp is None else stamp
        if now - since > COMMAND_TIMEOUT:
            return f"stamped {now - since:.2f} s ago, over the time-out of {COMMAND_TIMEOUT:g} s"
        self._wanted, _ = self._limits.within(np.asarray(velocity, dtype=float))
        self._until = since + COMMAND_TIMEOUT
        return ""

    def halt(self) -> None:
        """Forget the command."""
        self._until = -math.inf

    def advance(self, now: float, dt: float) -> Array:
        """Velocity (3,) of the base during the next ``dt`` [s] from a time [s] on."""
        wanted = self._wanted if now <= self._until else np.zeros(3)
        largest = dt * np.array((*(self._limits.acceleration,) * 2, self._limits.angular_acceleration))
        self._velocity = self._velocity + np.clip(wanted - self._velocity, -largest, largest)
        return self._velocity
