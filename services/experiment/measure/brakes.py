"""When the tool was braked: the controller rested it, or the robot's gate had no fresh command to execute.

A brake is a safety action that has to happen when a sample or a command is late. It stops the tool at once, and a load
that hangs from it swings for a moment; what a law does is judged outside of that, and the brakes are told beside it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from services.experiment.play.recording import Recording
from shared import topics
from shared.robot.side import HOLDING_AFTER

SETTLING = 0.4
"""Time [s] after a brake: the tool is back at its speed in a quarter of a second, and the load was within 0.6 N of its
resting value from 0.3 s on after every brake that was looked at on a loaded machine."""
NO_COMMAND = "no fresh command"
_WORKING = ("tracking", "yielding")


@dataclass(frozen=True)
class Brake:
    """The tool was braked from ``start`` to ``end`` [s] as told, for less than that if the robot's gate did it."""

    start: float
    end: float
    reason: str


def brakes(recording: Recording) -> list[Brake]:
    """All brakes of a run in order; what follows within ``HOLDING_AFTER`` belongs to the same one."""
    found: list[Brake] = []
    for time, reason in sorted([*_controller(recording), *_gate(recording)]):
        # The gate tells of what it did a while later.
        start = time - HOLDING_AFTER if reason == NO_COMMAND else time
        if found and start <= found[-1].end + HOLDING_AFTER:
            last = found.pop()
            why = reason if last.reason == NO_COMMAND else last.reason
            found.append(Brake(min(start, last.start), time, why))
        else:
            found.append(Brake(start, time, reason))
    return found


def undisturbed(time: np.ndarray, found: Sequence[Brake]) -> np.ndarray:
    """Which of the times (n,) [s] lie outside every brake and ``SETTLING`` after it."""
    quiet = np.ones(len(time), bool)
    for brake in found:
        quiet &= (time < brake.start) | (time >= brake.end + SETTLING)
    return quiet


def resting(recording: Recording) -> np.ndarray:
    """Which messages (n,) of the controller's status say that it braked or waited."""
    return ~np.isin(recording.series(topics.CONTROL_STATUS.key, "state"), _WORKING)


def _controller(recording: Recording) -> list[tuple[float, str]]:
    key = topics.CONTROL_STATUS.key
    rests = resting(recording)
    reasons = recording.series(key, "reason")[rests]
    return [
        (float(time), str(reason).split(": ")[0])
        for time, reason in zip(recording.time(key)[rests], reasons, strict=True)
    ]


def _gate(recording: Recording) -> list[tuple[float, str]]:
    key = topics.STATE_ROBOT.key
    held = recording.series(key, "held")
    more = np.diff(held, prepend=held[:1]) > 0
    return [(float(time), NO_COMMAND) for time in recording.time(key)[more]]
