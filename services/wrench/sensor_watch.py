"""Faults that a sensor's readings show by themselves: an axis stuck or saturated, and readings beyond the range.

Repeating a value proves nothing by itself: simulators without noise, sensors of fewer axes, dead zones and coarse steps
do it in health. What an axis was like while it lived tells:

    noisy     readings went up and down in turns, as noise does and motion does not, by more than their steps q
    p         share of readings that repeated the one before (two standard deviations above what was seen); on a grid of
              steps q at least erf(q / (sqrt(2 pi) s)), s = mean change between readings: normal noise, mid-step
    stuck     a noisy axis repeats a value so often that p^repeats < 1e-9; or the weight beyond the sensor changes
              along an axis with the sensor's attitude and the reading does not
    saturated as stuck, but at an end of the declared range, or farther out than the axis has ever been
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from services.wrench.averaging import AXES, UNITS
from shared.spatial import Array

SATURATED = "saturated"
STUCK = "stuck"
SILENT = "silent"
INVALID = "invalid"

RESOLUTION = 1e-9  # [N, Nm] between equal readings: a living sensor's noise is far above, rounding below
FEWEST_REPEATS = 2  # at 30 Hz no more than this fits into 0.1 s
PERIODS_AHEAD = 2.5  # a value froze up to a period before its first sample; the next is a period off, and late
CHANCE = 1e-9  # of as many repeats in a living axis
FEWEST_READINGS, REMEMBERED = 20, 1000  # readings by which an axis is known; beyond so many the old ones fade
LEAST_TURNS = 0.2  # share of changes that go back: white noise 2/3, a first-order low pass 1/2, motion next to none
LEAST_CHANGES = 0.5  # share of readings that change
LEAST_SPREAD = 1.5  # steps in the mean change: below it p depends on where within a step the load lies
OUTLYING = 8.0  # mean steps from its mean at which the outermost value of an axis is no noise any more
DEAD_ZONE = (1.0, 20.0)  # mean steps between the value an axis rests at and the next ones it takes
LEAST_WEIGHT = (0.3, 0.3, 0.3, 0.02, 0.02, 0.02)  # [N, Nm] change of the weight beyond the sensor that has to show
SILENT_START = 2.0  # [s] after which an axis that has never changed is spoken of

_NONE: Array = np.zeros(6)


@dataclass(slots=True)
class _Axis:
    """One axis: the value it has, for how long, and what it was like while it lived."""

    value: float = math.nan
    held: float = 0.0
    repeats: int = 0
    weight: float = 0.0  # identified weight when the value came
    readings: float = 0.0
    changes: float = 0.0
    turns: float = 0.0
    step: float = 0.0  # the last change
    scale: float = 0.0  # mean size of a change
    mean: float = 0.0
    low: float = math.inf
    high: float = -math.inf
    rest: float = math.nan  # a value it stayed at for long, and left by itself
    gap: float = math.inf  # to the nearest other value it took since
    grid: float = math.inf  # largest step of which all changes were multiples; next to nothing if there is none
    stuck: bool = False

    def take(self, value: float, weight: float, dt: float) -> None:
        """A reading, and the identified weight in it."""
        change = value - self.value
        if abs(change) <= RESOLUTION:
            self.held += dt
            self.repeats += 1
            if math.isnan(self.weight):
                self.weight = weight
            return
        if math.isfinite(change):
            self._left(value, change)
        self.value, self.weight, self.held, self.repeats = value, weight, 0.0, 0
        self.low, self.high = min(self.low, value), max(self.high, value)

    def _left(self, value: float, change: float) -> None:
        """Another value: what the last one's stay says."""
        if self.repeats >= FEWEST_REPEATS and not self.stuck and self.repeats >= self.needed():
            self.rest, self.gap = self.value, math.inf
        if self.readings >= REMEMBERED:
            self.readings, self.changes, self.turns = self.readings / 2, self.changes / 2, self.turns / 2
        self.readings += 1 if self.stuck else 1 + self.repeats
        self.changes += 1
        self.turns += change * self.step < 0.0
        self.step, size = change, abs(change)
        share = max(0.02, 1.0 / self.changes)
        self.scale += share * (size - self.scale)
        self.mean += share * (value - self.mean)
        if value != self.rest:
            self.gap = min(self.gap, abs(value - self.rest))  # NaN compares false
        # Euclid's algorithm: what is left of a change beside whole steps holds whole steps too.
        left = size if self.grid == math.inf else abs(size - self.grid * round(size / self.grid))
        self.grid = left if left > RESOLUTION else self.grid

    def noisy(self, step: float) -> bool:
        """Whether it is known to have noise that would change the next readings, in steps of ``step`` at least."""
        return (
            self.readings >= FEWEST_READINGS
            and self.turns >= LEAST_TURNS * self.changes
            and self.changes >= LEAST_CHANGES * self.readings
            and self.scale >= LEAST_SPREAD * max(step, self.grid)
        )

    def needed(self) -> float:
        """So many repeats are no chance any more."""
        repeated = self.readings - self.changes
        chance = (repeated + 2.0 * math.sqrt(repeated) + 1.0) / self.readings if repeated >= 1.0 else 0.0
        if self.changes:
            mean = self.scale * self.changes / self.readings  # over repeats too
            chance = max(chance, math.erf(self.grid / (math.sqrt(2.0 * math.pi) * mean)))
        if chance >= 1.0:
            return math.inf
        return max(FEWEST_REPEATS, math.log(CHANCE) / math.log(chance)) if chance > 0.0 else FEWEST_REPEATS

    def heavy(self, weight: float, least: float, step: float, known: bool) -> bool:
        """Whether the weight has changed along with the attitude, and the reading has not."""
        if not self.changes and (not known or self.repeats < FEWEST_READINGS):
            return False
        smooth = self.readings >= FEWEST_READINGS and self.turns < LEAST_TURNS * self.changes
        if self.changes and not smooth and self.repeats < self.needed():
            return False  # noise may have hidden the change by chance
        return abs(weight - self.weight) > least + 2.0 * max(
            step, self.grid if self.changes >= FEWEST_READINGS / 2 else 0.0
        )

    def resting(self) -> bool:
        """Whether the value is the middle of a dead zone, by what was seen of it."""
        near, far = DEAD_ZONE
        return self.value == self.rest and near * self.scale < self.gap < far * self.scale

    def outermost(self) -> bool:
        """Whether it came to a value farther out than noise, than any other, and not in one leap as a fault does."""
        far = abs(self.value - self.mean)
        if self.readings < FEWEST_READINGS or far <= max(OUTLYING * self.scale, 2.0 * abs(self.step)):
            return False
        return self.value >= self.high if self.value > self.mean else self.value <= self.low


class SensorWatch:
    """Tells a living sensor from one that is stuck or saturated, and readings from what the sensor cannot read.

    A stuck axis is reported within ``stuck_after``, a coarse one as soon as its repeats are no chance any more. The
    report lasts until every axis has lived for as long again. What the robot process declares comes first.

    Attributes:
        reason: what shows the fault, with the way out; empty if there is none.
    """

    def __init__(self) -> None:
        self._axes = [_Axis() for _ in range(6)]
        self._recovery = 0.0
        self._word = ""
        self._age = 0.0
        self.reason = ""

    def update(
        self,
        reading: Array,
        saturated: bool,
        dt: float,
        stuck_after: float,
        resolution: tuple[float, ...] = (0.0,) * 6,
        sensor_range: tuple[float, ...] = (math.inf,) * 6,
        weight: Array = _NONE,
        known: bool = False,
    ) -> str:
        """The fault that the newest reading shows, empty if none.

        Args:
            reading: raw force and torque (6,) [N, Nm].
            saturated: the robot's own word that an axis is at the end of its range.
            dt: time [s] since the last reading.
            stuck_after: time [s] within which a stuck axis has to be reported.
            resolution: declared step of the readings (6,) [N, Nm], or width of a dead zone; 0 = unknown.
            sensor_range: largest reading of each axis (6,) [N, Nm].
            weight: beyond the sensor at this attitude (6,), at least, sensor axes.
            known: that is the weight of an identified payload, and shows in axes too that have never changed.
        """
        self._age += dt
        values = reading.tolist()
        weights = weight.tolist()
        word = reason = ""
        for number, axis in enumerate(self._axes):
            value, step = values[number], resolution[number]
            axis.take(value, weights[number], dt)
            if abs(value) >= sensor_range[number]:
                beyond = abs(value) > sensor_range[number] + RESOLUTION
                word, reason = (INVALID if beyond else SATURATED), self._at_its_end(number, sensor_range[number])
            elif axis.repeats and not axis.stuck:
                in_time = axis.held + PERIODS_AHEAD * dt > stuck_after  # the next reading could be too late
                axis.stuck = axis.heavy(weights[number], LEAST_WEIGHT[number], step, known) or (
                    in_time and axis.noisy(step) and axis.repeats >= axis.needed() and not axis.resting()
                )
            elif not axis.repeats:
                axis.stuck = False
        if saturated:
            self.reason = "the robot says that an axis is at the end of its range: less force, or a larger sensor"
            return SATURATED
        if word:
            self.reason = reason
            return word
        stuck = [number for number, axis in enumerate(self._axes) if axis.stuck]
        if stuck:
            self._recovery = stuck_after
            self._word, self.reason = self._of_stuck(stuck)
            return self._word
        self._recovery = max(0.0, self._recovery - dt)
        if self._recovery > 0.0:
            return self._word
        self.reason = ""
        return ""

    def reweigh(self) -> None:
        """The weight given from now on is another one: only its changes from here on count."""
        for axis in self._axes:
            axis.weight = math.nan

    def notes(self) -> str:
        """Axes that have never changed, which is no proof of a fault; empty if there is none."""
        still = [number for number, axis in enumerate(self._axes) if not axis.changes]
        if not still or self._age < SILENT_START:
            return ""
        if len(still) == 6:
            return (
                "the force sensor has repeated its first reading since the start: is it a simulator without noise? "
                "Declare its `resolution`, such as 1e-6, or a zero is known to `bias_bound` only"
            )
        return (
            f"{_named(still, self._axes)} since the start: a sensor of fewer axes, or one without noise? "
            "What acts along an axis that is not measured is not felt"
        )

    def _of_stuck(self, stuck: list[int]) -> tuple[str, str]:
        ends = [number for number in stuck if self._axes[number].outermost()]
        if ends:
            return SATURATED, (
                f"{_named(ends, self._axes)}, farther out than ever: the end of its range? Less force; "
                "`sensor_range` declares it"
            )
        who = "all axes have repeated one reading" if len(stuck) == 6 else _named(stuck, self._axes)
        cause = "does its driver repeat an old sample" if len(stuck) == 6 else "its cable or its driver"
        return STUCK, (
            f"{who} although noise or weight should change it: {cause}? If the sensor is sound but coarse, or has a "
            "dead zone, declare that step with `resolution`, or raise `stuck_after`"
        )

    def _at_its_end(self, number: int, limit: float) -> str:
        return (
            f"{AXES[number]} is {self._axes[number].value:.4g} {UNITS[number]}, the sensor reads up to {limit:g} "
            "(`sensor_range`): less force, or declare the range of this sensor"
        )


def _named(numbers: list[int], axes: list[_Axis]) -> str:
    """Axes with the value that each has repeated."""
    shown = ", ".join(f"{AXES[n]} at {axes[n].value:.6g} {UNITS[n]}" for n in numbers)
    return f"{shown} {'has' if len(numbers) == 1 else 'have'} not changed"
