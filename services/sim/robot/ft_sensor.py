"""The wrist's force-torque sensor: what it makes of the true wrench."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from shared.robot.tiago import SENSOR_RANGE
from shared.spatial import Array

DITHER = 1e-6
"""Least standard deviation [N, Nm] of the noise: no real sensor repeats a value to the last bit, and who watches one
takes an axis that does for stuck."""


class ForceTorqueSensor:
    """Adds bias and white noise, and saturates.

    Args:
        noise: standard deviation per axis (6,) [N, Nm]; below ``DITHER`` it is that.
        bias: constant error per axis (6,) [N, Nm].
        seed: of the noise; the same seed gives the same readings.
    """

    def __init__(self, noise: Sequence[float], bias: Sequence[float], seed: int) -> None:
        self._noise = np.maximum(noise, DITHER)
        self._bias = np.array(bias)
        self._random = np.random.default_rng(seed)

    def read(self, wrench: Array) -> tuple[Array, bool]:
        """One reading (6,) [N, Nm] of a true wrench (6,), both in sensor axes, and whether an axis is saturated."""
        reading = wrench + self._bias + self._noise * self._random.standard_normal(6)
        clipped = np.minimum(np.maximum(reading, -SENSOR_RANGE), SENSOR_RANGE)
        return clipped, clipped.tolist() != reading.tolist()
