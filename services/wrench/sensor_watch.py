"""Faults that a sensor's readings show by themselves: an axis that is stuck, and saturation."""

from __future__ import annotations

import math

from shared.spatial import Array

SATURATED = "saturated"
STUCK = "stuck"
SILENT = "silent"
INVALID = "invalid"

RESOLUTION = 1e-9  # [N, Nm] between equal readings: a living sensor's noise is far above, rounding below
FEWEST_REPEATS = 2  # a coarse sensor repeats a value by chance; at 30 Hz no more than this fits into 0.1 s
PERIODS_AHEAD = 2.5  # a value froze up to a period before its first sample; the next is a period off, and late


class SensorWatch:
    """Tells a living sensor from one that is stuck or saturated.

    An axis is stuck if it repeats one value for ``stuck_after``: the noise of a living sensor changes each reading. The
    report comes within that time, and lasts until every axis has lived for as long again. A sensor whose steps are
    coarser than its noise needs a longer ``stuck_after``. A saturated axis repeats its end value too, so saturation,
    which the robot process declares, comes first.
    """

    def __init__(self) -> None:
        self._anchor = [math.nan] * 6
        self._held = [0.0] * 6
        self._repeats = [0] * 6
        self._recovery = 0.0

    def update(self, reading: Array, saturated: bool, dt: float, stuck_after: float) -> str:
        """The fault that the newest reading shows, empty if none.

        Args:
            reading: raw force and torque (6,) [N, Nm].
            saturated: the robot's own word that an axis is at the end of its range.
            dt: time [s] since the last reading.
            stuck_after: time [s] within which a stuck axis has to be reported.
        """
        stuck = False
        values = reading.tolist()
        anchor = self._anchor
        for axis, value in enumerate(values):
            if not abs(value - anchor[axis]) <= RESOLUTION:  # true for the first reading, whose anchor is NaN
                anchor[axis] = value
                self._held[axis] = 0.0
                self._repeats[axis] = 0
            else:
                self._held[axis] += dt
                self._repeats[axis] += 1
                # Waiting for the next reading could be too late.
                in_time = self._held[axis] + PERIODS_AHEAD * dt > stuck_after
                stuck |= in_time and self._repeats[axis] >= FEWEST_REPEATS
        if saturated:
            return SATURATED
        self._recovery = stuck_after if stuck else max(0.0, self._recovery - dt)
        return STUCK if self._recovery > 0.0 else ""
