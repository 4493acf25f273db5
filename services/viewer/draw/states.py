"""Who is in which state since when: a lane each for task, controller, robot, base, person and everybody's health."""

from __future__ import annotations

from collections.abc import Mapping

import rerun as rr

from services.viewer.draw.colours import AMBER, BLUE, GREEN, GREY, PALE, RED, TEAL

PHASES, HEALTH = "phases", "health"
LANES: dict[str, dict[str, tuple[int, ...]]] = {
    f"{PHASES}/task": {
        "idle": GREY,
        "calibrating": PALE[2],
        "searching": PALE[2],
        "approaching": BLUE,
        "grasping": BLUE,
        "carrying": GREEN,
        "releasing": TEAL,
        "retreating": TEAL,
        "done": GREY,
        "holding": RED,
    },
    f"{PHASES}/control": {"waiting": GREY, "tracking": GREEN, "yielding": AMBER, "braking": RED},
    f"{PHASES}/robot": {"ready": GREEN, "holding": AMBER, "stopped": RED},
    f"{PHASES}/base": {"off": GREY, "following": GREEN, "braking": RED},
}
"""Colour of each state of which it is known."""
_HEALTH = {"starting": GREY, "ok": GREEN, "degraded": AMBER, "fault": RED, "silent": RED}


def style(rec: rr.RecordingStream, services: tuple[str, ...]) -> None:
    """Colours of the states, once."""
    for path, colours in LANES.items():
        rec.log(path, _configuration(colours), static=True)
    for name in services:
        rec.log(f"{HEALTH}/{name}", _configuration(_HEALTH), static=True)


def _configuration(colours: Mapping[str, tuple[int, ...]]) -> rr.StateConfiguration:
    return rr.StateConfiguration(values=list(colours), labels=list(colours), colors=list(colours.values()))


def state(rec: rr.RecordingStream, path: str, word: str) -> None:
    """Something is in another state from now on."""
    rec.log(path, rr.StateChange(state=word))
