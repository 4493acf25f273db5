"""Faults that a sensor's readings show by themselves: an axis stuck or saturated, and readings beyond the range.

Repeating a value proves nothing by itself: simulators without noise, sensors of fewer axes, dead zones and coarse steps
do it in health. What an axis was like while it lived tells:

    stuck     a noisy axis repeats a value so often that p^repeats < 1e-9 (`AxisWatch`), and not that of its dead zone;
              or the weight beyond the sensor changes along an axis with the attitude and the reading does not
    saturated as stuck, but at an end of the declared range, or farther out than the axis has ever been
"""

from __future__ import annotations

import math

import numpy as np

from services.wrench.averaging import AXES, UNITS
from services.wrench.axis_watch import RESOLUTION, AxisWatch
from shared.spatial import Array

SATURATED = "saturated"
STUCK = "stuck"
SILENT = "silent"
INVALID = "invalid"

PERIODS_AHEAD = 2.5  # a value froze up to a period before its first sample; the next is a period off, and late
LEAST_WEIGHT = (0.3, 0.3, 0.3, 0.02, 0.02, 0.02)  # [N, Nm] change of the weight beyond the sensor that has to show
SILENT_START = 2.0  # [s] after which an axis that has never changed is spoken of

_NONE: Array = np.zeros(6)


class SensorWatch:
    """Tells a living sensor from one that is stuck or saturated, and readings from what the sensor cannot read.

    A stuck axis is reported within ``stuck_after``, a coarse one as soon as its repeats are no chance any more. The
    report lasts until every axis has lived for as long again. What the robot process declares comes first.

    Attributes:
        reason: what shows the fault, with the way out; empty if there is none.
        zones: half the width (6,) [N, Nm] at most of the dead zones that have shown and are not declared.
    """

    def __init__(self) -> None:
        self._axes = [AxisWatch() for _ in range(6)]
        self._recovery = 0.0
        self._word = ""
        self._age = 0.0
        self.reason = ""
        self.zones: Array = _NONE

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
                    in_time and axis.noisy(step) and axis.repeats >= axis.needed(here=True) and not axis.resting()
                )
            elif not axis.repeats:
                axis.stuck = False
        zones = [0.0 if step else axis.zone() for axis, step in zip(self._axes, resolution, strict=True)]
        self.zones = np.array(zones) if any(zones) else _NONE
        if saturated:
            self.reason = "the robot says that an axis is at the end of its range: less force, or a larger sensor"
            return SATURATED
        if word:
            self.reason = reason
            return word
        stuck = [number for number, axis in enumerate(self._axes) if axis.stuck]
        if stuck:
            self._recovery = stuck_after
            self._word, self.reason = self._of_stuck(stuck, sensor_range)
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
        """Dead zones, and axes that have never changed, which is no proof of a fault; empty if there is none."""
        found = "; ".join(
            f"{AXES[n]} is at {self._axes[n].rest:.6g} {UNITS[n]} or at least {zone:.2g} away from it: a dead zone? It "
            "counts in the error bound; declare it with `resolution`"
            for n, zone in enumerate(self.zones.tolist())
            if zone
        )
        return found or self._unmoved()

    def _unmoved(self) -> str:
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

    def _of_stuck(self, stuck: list[int], limits: tuple[float, ...]) -> tuple[str, str]:
        ends = [number for number in stuck if self._axes[number].outermost(limits[number])]
        if ends:
            return SATURATED, (
                f"{_named(ends, self._axes)}, farther out than ever: the end of its range, or its cable? Less "
                "force; `sensor_range` declares it"
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


def _named(numbers: list[int], axes: list[AxisWatch]) -> str:
    """Axes with the value that each has repeated."""
    shown = ", ".join(f"{AXES[n]} at {axes[n].value:.6g} {UNITS[n]}" for n in numbers)
    return f"{shown} {'has' if len(numbers) == 1 else 'have'} not changed"
