"""Whether the machine kept time during a run, so that what failed there may be the machine's doing."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from services.experiment.measure.brakes import resting
from services.experiment.play.recording import Recording
from shared import topics

GAP = 0.15  # [s] without a sample; the services latch a sensor failure after 0.1 s
HELD = 0.02  # share of the time


def longest_gap(recording: Recording) -> float:
    """Longest time [s] between two samples of the force sensor."""
    time = recording.time(topics.SENSOR_FT.key)
    return float(np.max(np.diff(time[time >= 0.0]), initial=0.0))


def unhealthy(recording: Recording, start: float = 0.0) -> float:
    """Share of the time from a time [s] on during which the controller braked or waited."""
    rests = resting(recording)[recording.time(topics.CONTROL_STATUS.key) >= start]
    return float(np.mean(rests)) if len(rests) else 1.0


def disturbances(measured: Mapping[str, Any]) -> list[str]:
    """A line for each run whose figures `longest_gap` and `unhealthy` say that it did not."""
    return [
        f"{name}: the force sensor was silent for up to {1e3 * found.longest_gap:.0f} ms and the controller held still "
        f"{100 * found.unhealthy:.0f} % of the time: the machine is overloaded or a process was disturbed"
        for name, found in measured.items()
        if found.longest_gap > GAP or found.unhealthy > HELD
    ]
