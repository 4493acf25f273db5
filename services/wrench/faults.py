"""Faults that a sensor's readings show by themselves: an axis that is stuck, and saturation."""

from __future__ import annotations

import numpy as np

from shared.spatial import Array

SATURATED = "saturated"
STUCK = "stuck"
SILENT = "silent"
INVALID = "invalid"

RESOLUTION = 1e-9
"""Difference [N, Nm] up to which two readings are the same. A living sensor's noise is far above, rounding below."""
FEWEST_REPEATS = 3
"""A reading may repeat by chance (quantisation); this often in a row it does not."""


class SensorWatch:
    """Tells a living sensor from one that is stuck or saturated.

    An axis is stuck if it repeats one value for ``stuck_after``: the noise of a living sensor changes each reading. It
    is reported with the last sample that falls within that time, and until every axis has lived for as long again. A
    saturated axis repeats its end value too, so saturation, which the robot process declares, is asked first.
    """

    def __init__(self) -> None:
        self._anchor: Array | None = None
        self._held = np.zeros(6)
        self._repeats = np.zeros(6, dtype=int)
        self._recovery = 0.0

    def update(self, reading: Array, saturated: bool, dt: float, stuck_after: float) -> str:
        """The fault that the newest reading shows, empty if none.

        Args:
            reading: raw force and torque (6,) [N, Nm].
            saturated: the robot's own word that an axis is at the end of its range.
            dt: time [s] since the last reading.
            stuck_after: time [s] within which a stuck axis has to be reported.
        """
        if self._anchor is None:
            self._anchor = reading.copy()
        else:
            same = np.abs(reading - self._anchor) <= RESOLUTION
            self._held = np.where(same, self._held + dt, 0.0)
            self._repeats = np.where(same, self._repeats + 1, 0)
            self._anchor = np.where(same, self._anchor, reading)
        if saturated:
            return SATURATED
        # With the next reading, dt later, it would be too late.
        stuck = (self._held + dt > stuck_after) & (self._repeats >= FEWEST_REPEATS)
        self._recovery = stuck_after if stuck.any() else max(0.0, self._recovery - dt)
        return STUCK if self._recovery > 0.0 else ""

    def stuck_axes(self) -> list[int]:
        """Indices of the axes that repeat their value at present."""
        return np.flatnonzero(self._repeats >= FEWEST_REPEATS).tolist()
