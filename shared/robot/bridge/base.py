"""The mobile base of a bridge: the gate's velocity, sent as long as the base is to move."""

from __future__ import annotations

import numpy as np

from shared.spatial import Array

PERIOD = 0.02
"""[s] between two velocities: the robot's own time-outs are ten times as long."""
FADING = 0.3
"""[s] of zeros at the end of a motion. Then others may drive the base: who keeps quiet holds no input of twist_mux."""
BLOCKED_AFTER = 1.0
"""[s] of being commanded without moving after which something keeps the commands from the base."""
_MOVING = 0.03  # [m/s, rad/s] commanded that a base has to show
_SHOWN = 0.1  # [1] share of it that counts as moving


class BaseDrive:
    """Sends velocities to a base.

    Attributes:
        blocked: whether it does not move although it is told to.
    """

    def __init__(self) -> None:
        self.blocked = False
        self._velocity: Array = np.zeros(3)
        self._until_next = 0.0
        self._zeros = 0.0
        self._unmoved = 0.0

    @property
    def moving(self) -> bool:
        """Whether it was told to move at last."""
        return bool(self._velocity.any())

    def advance(self, velocity: Array, measured: Array | None, dt: float) -> Array | None:
        """The velocity to send now, if one is.

        Args:
            velocity: that the gate lets through (3,) vx, vy [m/s], wz [rad/s].
            measured: by odometry (3,); None if there is none.
            dt: since the last call [s].
        """
        halted = bool(self._velocity.any()) and not velocity.any()
        self._velocity = velocity
        self._watch(measured, dt)
        self._zeros = FADING if velocity.any() else self._zeros - dt
        self._until_next -= dt
        if self._zeros <= 0.0 or (self._until_next > 1e-6 and not halted):
            return None
        self._until_next = PERIOD
        return velocity

    def _watch(self, measured: Array | None, dt: float) -> None:
        wanted = float(np.abs(self._velocity).max())
        if wanted < _MOVING:
            self._unmoved = 0.0
            return
        moved = measured is not None and float(np.abs(measured).max()) > _SHOWN * wanted
        self._unmoved = 0.0 if moved else self._unmoved + dt
        if moved:
            self.blocked = False
        self.blocked |= self._unmoved > BLOCKED_AFTER
