"""What the page shows, as plain values for a browser: a pure function of what was heard.

Everything comes with its age; what is old is left to the page to call so, since its own connection may be old, too.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from services.viewer.heard import Known
from services.viewer.sentence import Sentence
from shared.topics import SIM_WORLD, STATE_BASE, STATE_ROBOT, TASK_STATUS, Topic

ONLY_SIMULATED = "only a simulation has hands to lead: beside a real robot they are yours"
UNKNOWN = "no robot has said yet whether it is a simulation"
NOBODY = "there is no person in this simulated scene"


def shown(run: str, robot: str, sentence: Sentence, known: Known, forbidden: Mapping[str, str]) -> dict[str, Any]:
    """All that a page needs between two questions.

    Args:
        run: another one with every start of the viewer.
        robot: name of the robot.
        sentence: why the robot does what it does.
        known: what was heard.
        forbidden: by the name of an action, why it is not allowed; empty if it is.
    """
    world = _of(known, SIM_WORLD)
    hand, panel = (world or {}).get("hand"), (world or {}).get("panel")
    return {
        "run": run,
        "robot": robot,
        "sentence": {"text": sentence.text, "kind": sentence.kind.value, "more": sentence.more[:6]},
        "gate": _of(known, STATE_ROBOT, "mode", "reason", "simulated", "require_enable"),
        "task": _of(known, TASK_STATUS, "state", "reason"),
        "base": _of(known, STATE_BASE, "position", "yaw"),
        "hand": None if hand is None else {**hand, "age": (world or {})["age"]},
        "panel": panel,
        "forbidden": {**forbidden, "hand": forbidden.get("hand") or _no_hand(known)},
    }


def _no_hand(known: Known) -> str:
    """Why there are no hands to lead; empty if there are."""
    gate, world = known.get(STATE_ROBOT.key), known.get(SIM_WORLD.key)
    if gate is None:
        return UNKNOWN
    if not gate.message.simulated:  # type: ignore[attr-defined]
        return ONLY_SIMULATED
    return NOBODY if world is not None and world.message.panel is None else ""  # type: ignore[attr-defined]


def _of(known: Known, topic: Topic, *fields: str) -> dict[str, Any] | None:
    """Fields of a topic's newest message, all if none is named, and its age [s]; None before the first one."""
    told = known.get(topic.key)
    if told is None:
        return None
    plain = told.message.to_plain()
    return {name: plain[name] for name in fields or plain} | {"age": round(told.age, 2)}
