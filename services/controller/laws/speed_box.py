"""How fast the tool may move now: limits of speed and of speeding up, as a box around standing still."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from services.controller.parameters import ControllerParameters
from shared.spatial import Array

_TURN = 0.01
"""Rotation [rad] up to which the acceleration limits of the last attitude are kept, with a margin for it."""


def rotated_limits(rotation: Array, limits: ArrayLike) -> Array:
    """Half-widths (3,) or (3, n) of boxes in base axes that lie within the boxes ``limits`` of the tool axes.

    Continuous in the rotation and exact where the axes coincide; at worst (diagonal) smaller by sqrt(3).
    """
    share = np.abs(rotation)
    box = 1.0 / share.dot(1.0 / np.asarray(limits))
    fit = np.minimum.reduce(limits / share.T.dot(box))
    return np.minimum(fit, 1.0) * box


def _with_margin(acceleration: ArrayLike) -> tuple[Array, Array]:
    """Limits (3, 2) and margin (2,) that keep the box inside the tool's for every attitude closer than ``_TURN``."""
    limits = np.array(acceleration).reshape((2, 3)).T
    margin = math.sqrt(3.0) * _TURN * limits.max(axis=0)
    return limits / (1.0 + 2.0 * margin / limits.min(axis=0)), margin


class SpeedBox:
    """The box ``-reach[:6] <= v <= reach[6:]`` in base axes, which always contains 0.

    Speeding up is limited, slowing down never is: from the last command the box reaches to zero and, by
    ``max_acceleration`` times the interval, beyond it. The box of what gives way reaches farther.

    Attributes:
        reach: (12,) largest speeds [m/s, rad/s] in the twelve directions (see ``TravelInFlight``).
        speed: (6,), the speed limits alone.
        payload: whether there is one beyond the sensor.
        inertial_force: (6,) [N, 0] that accelerating the payload can add to the measured wrench.
    """

    def __init__(self, parameters: ControllerParameters) -> None:
        self.reach = np.zeros(12)
        self._acceleration, self._retreat = np.zeros(12), np.zeros(12)
        self._turned = np.zeros((3, 3))
        self._difference = self._turned.ravel()
        self.configure(parameters)

    def configure(self, parameters: ControllerParameters) -> None:
        """Take over changed limits."""
        self._linear, self._angular = parameters.max_linear, parameters.max_angular
        self.speed = [self._linear] * 3 + [self._angular] * 3
        self._speed = np.array(self.speed * 2)
        # Columns: linear, angular.
        self._limits, margin = _with_margin(parameters.max_acceleration)
        self._retreat_limits, _ = _with_margin(parameters.retreat_acceleration)
        self.payload = parameters.payload_mass > 0.0
        self._inertia = parameters.payload_mass * np.array(parameters.max_acceleration[:3])
        self._inertial_margin = parameters.payload_mass * margin[0]
        self._period = parameters.period
        self._rotation = np.full((3, 3), np.inf)
        self.inertial_force = np.zeros(6)

    def update(self, rotation: Array, speeds: Array, dt: float) -> None:
        """The box for a tool attitude (3, 3).

        Args:
            rotation: (3, 3), tool to base.
            speeds: (12,) of the command that acts until now.
            dt: [s] since the last command.
        """
        difference = self._difference
        np.subtract(rotation, self._rotation, self._turned)
        if not difference.dot(difference) < _TURN**2:
            self._turn_to(rotation)
        self._reach_by(self._acceleration, speeds, dt, self.reach)

    def retreat_reach(self, speeds: Array, dt: float) -> Array:
        """Largest speeds (12,) [m/s, rad/s] of what gives way, for the attitude and arguments of ``update``."""
        return self._reach_by(self._retreat, speeds, dt, np.empty(12))

    def _reach_by(self, acceleration: Array, speeds: Array, dt: float, reach: Array) -> Array:
        np.multiply(acceleration, dt if dt < self._period else self._period, reach)
        np.add(reach, speeds, reach)
        return np.minimum(reach, self._speed, out=reach)

    def _turn_to(self, rotation: Array) -> None:
        self._rotation = rotation.copy()
        self._acceleration.reshape((2, 2, 3))[:] = rotated_limits(rotation, self._limits).T
        self._retreat.reshape((2, 2, 3))[:] = rotated_limits(rotation, self._retreat_limits).T
        if self.payload:
            self.inertial_force[:3] = np.abs(rotation).dot(self._inertia) + self._inertial_margin

    def shortened(self, twist: Array) -> Array | None:
        """The twist, scaled as a whole until its linear and angular norms are within the limits; None if not finite.

        The robot's gate limits the two norms separately, which would bend the twist; scaled here, it never has to.
        """
        x, y, z, a, b, c = twist.tolist()
        linear, angular = math.hypot(x, y, z), math.hypot(a, b, c)
        if not linear + angular < math.inf:
            return None
        excess = max(linear / self._linear, angular / self._angular)
        return twist / excess if excess > 1.0 else twist.copy()
