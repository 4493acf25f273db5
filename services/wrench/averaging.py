"""Averaging readings while the tool stands still and nothing happens to it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from shared.spatial import Array, rotation_from_vector, rotation_vector

FEWEST_SAMPLES = 10  # the mean and the standard deviation of fewer readings say too little
LARGEST_TURN = 0.01  # [rad] of the sensor within the window: more is moving, and 1 % of the weight beyond it
SIGMAS = 5.0  # standard deviations taken as a bound: a normal error is beyond it once in 1.7 million readings

AXES = ("force x", "force y", "force z", "torque x", "torque y", "torque z")
UNITS = ("N", "N", "N", "Nm", "Nm", "Nm")


class NotStill(ValueError):
    """The readings are of no use for an average; the text says why."""


@dataclass(frozen=True)
class Average:
    """Average of a window.

    Attributes:
        mean: (6,) [N, Nm], sensor axes.
        std: (6,) [N, Nm] standard deviation of one reading.
        samples: number of readings.
        rotation: sensor in base (3, 3).
        peak: (6,) [N, Nm] largest distance of a reading from the mean: spikes are more than their standard deviation.
        rounding: bound (6,) [N, Nm] on what steps or a dead zone make the mean wrong by.
        independent: (6,) how many independent readings these are worth.
        unknown: bound (6,) [N, Nm] on how coarse an axis may be that repeated one value.
    """

    mean: Array
    std: Array
    samples: int
    rotation: Array
    peak: Array = field(default_factory=lambda: np.zeros(6))
    rounding: Array = field(default_factory=lambda: np.zeros(6))
    independent: Array | None = None
    unknown: Array = field(default_factory=lambda: np.zeros(6))

    @property
    def variance(self) -> Array:
        """Variance (6,) [N2, Nm2] of the mean, without rounding."""
        variance: Array = self.std**2 / (self.samples if self.independent is None else self.independent)
        return variance

    @property
    def mean_error(self) -> Array:
        """Bound (6,) [N, Nm] on the error of the mean."""
        return SIGMAS * np.sqrt(self.variance) + self.rounding + self.unknown

    @property
    def noise(self) -> Array:
        """Bound (6,) [N, Nm] on the noise of one reading."""
        return np.maximum(SIGMAS * self.std, self.peak) + self.rounding


class AveragingWindow:
    """Collects readings for ``duration`` [s]; refuses those that are not of a tool at rest.

    Args:
        duration: [s].
        noise_bound: (6,) [N, Nm] declared bound on the sensor's noise, sensor axes.
        resolution: (6,) [N, Nm] declared step of the readings, or reading up to which they are zero, 0 = unknown.
        coarsest: (6,) [N, Nm] bound on the error of an axis that repeats one value, if its resolution is not declared.
    """

    def __init__(self, duration: float, noise_bound: Array, resolution: Array, coarsest: Array) -> None:
        self._left = duration
        self._noise_bound = noise_bound
        self._resolution, self._coarsest = resolution, coarsest
        self._readings: list[Array] = []
        self._rotations: list[Array] = []

    def add(self, reading: Array, rotation: Array, dt: float) -> bool:
        """Whether the window is full with this reading and its sensor in base, ``dt`` [s] after the last."""
        if self._readings:
            self._left -= dt
        self._readings.append(reading)
        self._rotations.append(rotation)
        return self._left <= 0.0

    def average(self) -> Average:
        """Average of the window.

        Raises:
            NotStill: if there are too few readings, or the tool turned, was moved or touched.
        """
        count = len(self._readings)
        if count < FEWEST_SAMPLES:
            raise NotStill(f"only {count} samples came in, wanted at least {FEWEST_SAMPLES}: use a longer duration")
        rotation = self._mean_rotation()
        readings = np.array(self._readings)
        mean, std = readings.mean(axis=0), readings.std(axis=0, ddof=1)
        half = count // 2
        drift = np.abs(readings[:half].mean(axis=0) - readings[half:].mean(axis=0))
        allowed = self._noise_bound + self._resolution
        drift_limit = np.maximum(0.5 * allowed, 2.0 * SIGMAS * std / math.sqrt(count))
        for what, values, limits in (("varies", std, allowed), ("drifts", drift, drift_limit)):
            axis = int(np.argmax(values / limits))
            if values[axis] > limits[axis]:
                raise NotStill(
                    f"{AXES[axis]} {what} by {values[axis]:.3g}, allowed are {limits[axis]:.3g} {UNITS[axis]}: "
                    "the tool moves or something touches it. Let it stand still and free, or raise noise_bound"
                )
        rounding = np.array([_rounding(readings[:, axis]) for axis in range(6)])
        # Of an axis that repeats one value nobody knows how coarse it is, whether the others have noise or not.
        unknown = np.where(np.isinf(rounding) & (self._resolution <= 0.0), self._coarsest, 0.0)
        rounding = np.where(self._resolution > 0.0, self._resolution, np.where(np.isinf(rounding), 0.0, rounding))
        return Average(
            mean,
            std,
            count,
            rotation,
            np.abs(readings - mean).max(axis=0),
            rounding,
            _independent(readings - mean),
            unknown,
        )

    def _mean_rotation(self) -> Array:
        first = self._rotations[0]
        turns = np.array([rotation_vector(rotation @ first.T) for rotation in self._rotations])
        largest = float(np.sqrt((turns**2).sum(axis=1)).max())
        if largest > LARGEST_TURN:
            raise NotStill(f"the sensor turned by {largest:.3f} rad, allowed are {LARGEST_TURN} rad: the tool moves")
        # Within a hundredth of a radian the mean of the rotation vectors is the mean of the rotations.
        return rotation_from_vector(turns.mean(axis=0)) @ first


def _independent(deviations: Array) -> Array:
    """How many independent readings (6,) some are worth, by the correlation of each with the next: n (1 - r) / (1 + r).

    A sensor with a low pass gives readings that resemble each other, whose mean is known the less well.

    Args:
        deviations: from the mean (n, 6).
    """
    count = len(deviations)
    power = (deviations**2).sum(axis=0)
    together = (deviations[1:] * deviations[:-1]).sum(axis=0) / np.where(power > 0.0, power, 1.0)
    # What white noise reaches by chance in 3 of 1000 axes counts as none.
    share = np.where(together > 3.0 / math.sqrt(count), np.minimum(together, 1.0 - 1.0 / count), 0.0)
    independent: Array = count * (1.0 - share) / (1.0 + share)
    return independent


def _rounding(readings: Array) -> float:
    """What steps or a dead zone may make the mean of an axis' readings (n,) wrong by; infinite if all are the same.

    Noise of half a step and more makes the mean of rounded readings right. A dead zone shows by a value that comes far
    more often than others do, and has none near it; of three values nobody knows whether they are steps.
    """
    values, counts = np.unique(readings, return_counts=True)
    if len(values) == 1:
        return math.inf
    step = float(np.diff(values).min())
    often = int(np.argmax(counts))
    gap = float(np.abs(np.delete(values, often) - values[often]).min())
    # What comes more rarely than that is within five standard deviations of the mean, or next to nothing.
    stands_out = counts[often] > max(2.0 * np.median(np.delete(counts, often)), 0.05 * len(readings))
    zone = gap if stands_out and (gap > 2.0 * step or len(values) <= 3) else 0.0
    return max(zone, 0.5 * step if readings.std() < 0.5 * step else 0.0)
