"""A made-up sensor with known bias, payload and noise, for the tests of what finds them out again."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from services.wrench.averaging import Average, AveragingWindow
from services.wrench.compensation import Compensation, transport
from shared.messages import FtSample
from shared.spatial import Array, quaternion, rotation_from_vector

NOISE = np.array((0.1, 0.1, 0.1, 0.005, 0.005, 0.005))
NOISE_BOUND = 5 * NOISE
TOOL_OFFSET = np.array((0.0, 0.0, 0.155))
LEVEL = np.eye(3)
DOWN = np.array((0.0, 0.0, -1.0))
TILTED = [rotation_from_vector(v) for v in ((0, 0, 0), (0.6, 0, 0), (-0.6, 0, 0), (0, 0.6, 0), (0, -0.6, 0))]


def external_wrench(reading: Array, compensation: Compensation, rotation: Array, tool_offset: Array) -> Array:
    """What the service publishes for a raw reading (6,)."""
    return transport(rotation, tool_offset) @ (reading - compensation.offset(rotation))


@dataclass
class Sensor:
    """Readings follow f = R^T (external + m g) + b_f and the torque about the sensor's origin that belongs to it.

    ``external`` is (6,) at the tool's origin in base axes, ``gravity`` (3,) the unit vector of gravity there and
    ``told`` what the robot takes for it; everything else is in sensor axes.
    """

    mass: float = 0.8226
    com: Array = field(default_factory=lambda: np.array((0.004, -0.003, 0.09)))
    bias: Array = field(default_factory=lambda: np.array((1.5, -2.0, 0.7, 0.1, 0.05, -0.2)))
    noise: Array = field(default_factory=lambda: NOISE)
    gravity: Array = field(default_factory=lambda: DOWN)
    told: Array = field(default_factory=lambda: DOWN)
    seed: int = 0

    def __post_init__(self) -> None:
        self._random = np.random.default_rng(self.seed)

    def exact(self, rotation: Array, external: Array | None = None) -> Array:
        """Noise-free reading (6,)."""
        external = np.zeros(6) if external is None else external
        force = rotation.T @ external[:3]
        torque = rotation.T @ external[3:] + np.cross(TOOL_OFFSET, force)
        weight = self.mass * 9.81 * (rotation.T @ self.gravity)
        return np.concatenate((force + weight, torque + np.cross(self.com, weight))) + self.bias

    def reading(self, rotation: Array, external: Array | None = None) -> Array:
        """Noisy reading (6,)."""
        return self.exact(rotation, external) + self.noise * self._random.standard_normal(6)

    def sample(self, rotation: Array = LEVEL, external: Array | None = None, saturated: bool = False) -> FtSample:
        """A noisy reading as a message."""
        reading = self.reading(rotation, external)
        return FtSample(reading[:3], reading[3:], quaternion(rotation), TOOL_OFFSET, saturated, self.told)

    def average(self, rotation: Array, samples: int = 100) -> Average:
        """Average of noisy readings at rest."""
        window = AveragingWindow(1e9, NOISE_BOUND, np.zeros(6), NOISE_BOUND)
        for _ in range(samples):
            window.add(self.reading(rotation), rotation, 0.01)
        return window.average()
