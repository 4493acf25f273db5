"""Whether the machine kept time during a run, so that what failed there may be the machine's doing."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from services.experiment.measure.brakes import resting
from services.experiment.play.recording import Recording
from shared import topics

GAP = 0.15  # [s] without a sample; the services latch a sensor failure after 0.1 s
HELD = 0.02  # share of the time
LATE = 0.02  # share of a process's steps; one brakes by itself when 5 % of those of a second are late
_HEALTH = "health/"


def longest_gap(recording: Recording) -> float:
    """Longest time [s] between two samples of the force sensor."""
    if topics.SENSOR_FT.key not in recording.topics:
        return math.inf
    time = recording.time(topics.SENSOR_FT.key)
    return float(np.max(np.diff(time[time >= 0.0]), initial=0.0))


def unhealthy(recording: Recording, start: float = 0.0) -> float:
    """Share of the time from a time [s] on during which the controller braked or waited."""
    rests = resting(recording)[recording.time(topics.CONTROL_STATUS.key) >= start]
    return float(np.mean(rests)) if len(rests) else 1.0


def late_steps(recording: Recording) -> dict[str, float]:
    """Share of the steps of each process that were late while the run was played, by the process's own count."""
    found = {}
    for key in recording.topics:
        time = recording.time(key) if key.startswith(_HEALTH) else np.empty(0)
        played = time >= 0.0
        if np.count_nonzero(played) > 1:
            # A process that was started again counts anew.
            late = np.maximum(np.diff(recording.series(key, "overruns")[played]), 0).sum()
            steps = (recording.series(key, "loop_hz")[played][1:] * np.diff(time[played])).sum()
            found[key.removeprefix(_HEALTH)] = float(late / max(steps, 1.0))
    return found


def too_busy(recording: Recording) -> str:
    """By what the machine shows that it was too busy for the run to be judged; empty if it kept time."""
    late = late_steps(recording)
    told = [f"{100 * share:.1f} % of the steps of {name} were late" for name, share in late.items() if share > LATE]
    if told:
        told[-1] += f" (bound {100 * LATE:g} %)"
    if GAP < (gap := longest_gap(recording)) < math.inf:
        told.append(f"the force sensor was silent for {1e3 * gap:.0f} ms (bound {1e3 * GAP:g} ms)")
    return ", ".join(told)


def disturbances(measured: Mapping[str, Any]) -> list[str]:
    """A line for each run whose figures `longest_gap` and `unhealthy` say that it did not."""
    return [
        f"{name}: the force sensor was silent for up to {1e3 * found.longest_gap:.0f} ms and the controller held still "
        f"{100 * found.unhealthy:.0f} % of the time: the machine is overloaded or a process was disturbed"
        for name, found in measured.items()
        if found.longest_gap > GAP or found.unhealthy > HELD
    ]
