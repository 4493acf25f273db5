"""A wrist's force-torque sensor with all that real ones do, and the tool that hangs from it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from shared.robot.tiago import SENSOR_RANGE
from shared.spatial import GRAVITY, Array, cross

TOOL_OFFSET: Array = np.array((0.0, 0.0, 0.155))  # [m] of the tool's origin, sensor axes: TIAGo's gripper
DOWN: Array = np.array((0.0, 0.0, -1.0))


def _zeros() -> Array:
    return np.zeros(6)


@dataclass
class Sensor:
    """Readings are ``matrix`` times what acts on the sensor, and the errors of the rest; vectors of six in sensor axes.

    Attributes:
        mass: [kg] of the tool.
        com: its centre (3,) [m] from the sensor's origin.
        bias: [N, Nm].
        sigma: standard deviation of the noise [N, Nm], which never exceeds five of them.
        drift: of the bias [N, Nm] per minute.
        matrix: (6, 6) axes, signs, gains, crosstalk; the identity for a good one.
        in_base: readings are given in the axes of base.
        step: of its digits [N, Nm]; 0 for none.
        dead: [N, Nm] up to which an axis reads exactly zero.
        limit: [N, Nm] at which an axis ends.
        tells: whether the robot process says so.
        spike: [N, Nm] added to one reading of ``every``.
        repeats: how often the robot process sends each reading.
        frozen: axes that keep their last value.
    """

    mass: float
    com: Array
    bias: Array
    sigma: Array
    drift: Array = field(default_factory=_zeros)
    matrix: Array = field(default_factory=lambda: np.eye(6))
    in_base: bool = False
    step: Array = field(default_factory=_zeros)
    dead: Array = field(default_factory=_zeros)
    limit: Array = field(default_factory=lambda: SENSOR_RANGE.copy())
    tells: bool = True
    spike: Array = field(default_factory=_zeros)
    every: int = 37
    repeats: int = 1
    frozen: tuple[int, ...] = ()

    def exact(self, rotation: Array, gravity: Array, external: Array) -> Array:
        """What acts on the sensor (6,), about its origin in its axes.

        Args:
            rotation: sensor in base (3, 3).
            gravity: its true direction (3,), base axes.
            external: wrench (6,) on the tool's origin, base axes.
        """
        force, torque = rotation.T @ external[:3], rotation.T @ external[3:]
        weight = self.mass * GRAVITY * (rotation.T @ gravity)
        return np.concatenate((force + weight, torque + cross(TOOL_OFFSET, force) + cross(self.com, weight)))

    def reading(
        self, exact: Array, rotation: Array, minutes: float, number: int, random: np.random.Generator
    ) -> tuple[Array, bool]:
        """One reading (6,) of what acts on it, and whether the robot process calls it saturated.

        Args:
            exact: as ``exact`` gives it.
            rotation: sensor in base (3, 3).
            minutes: since it was switched on.
            number: of the reading.
            random: of the noise.
        """
        value = self.matrix @ exact
        if self.in_base:
            value = np.concatenate((rotation @ value[:3], rotation @ value[3:]))
        value = value + self.bias + self.drift * minutes
        value += self.sigma * np.clip(random.standard_normal(6), -5.0, 5.0)
        if number % self.every == 0:
            value += self.spike
        value = np.where(np.abs(value) < self.dead, 0.0, value)
        steps = np.where(self.step > 0.0, self.step, 1.0)
        value = np.where(self.step > 0.0, np.round(value / steps) * steps, value)
        ended = np.abs(value) >= self.limit
        return np.clip(value, -self.limit, self.limit), bool(self.tells and ended.any())
