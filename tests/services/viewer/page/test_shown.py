"""What a page is told: plain values with their ages, and why there are no hands to lead."""

from __future__ import annotations

import json

import pytest

from services.viewer.heard import Known, Told
from services.viewer.page.shown import NOBODY, ONLY_SIMULATED, UNKNOWN, shown
from services.viewer.sentence import Kind, Sentence
from shared.messages import RobotStatus, TaskStatus
from shared.sim_messages import HandState, PanelState, SimWorld
from shared.topics import SIM_WORLD, STATE_ROBOT, TASK_STATUS

SENTENCE = Sentence("held back by z force: 24.8 of 25 N", Kind.HELD, tuple(f"remark {number}" for number in range(20)))
ZERO = (0.0, 0.0, 0.0)
LEVEL = (0.0, 0.0, 0.0, 1.0)
HAND = HandState((1.9, -0.3, 1.0), (3.0, 0.0, 4.0), ZERO, "guided", (2.0, -0.3, 1.0))
PANEL = PanelState((1.2, -0.3, 0.8), LEVEL)


def robot(simulated: bool) -> Told:
    return Told(RobotStatus("ready", "", "omni", simulated, 0.25, 1.0, (0.5, 0.5, 1.0)), 0.123)


def world(panel: PanelState | None = PANEL, hand: HandState | None = HAND) -> Told:
    return Told(SimWorld(3.0, panel, None, hand, ZERO, True), 0.01)


def told(known: Known, **forbidden: str) -> dict:
    """As a browser gets it."""
    allowed = {"stop": "", "task": "", "hand": ""}
    return json.loads(json.dumps(shown("run", "tiago", SENTENCE, known, allowed | forbidden), allow_nan=False))


def test_before_anything_was_heard_nothing_is_claimed() -> None:
    state = told({})
    assert (state["gate"], state["task"], state["hand"], state["base"]) == (None,) * 4
    assert state["forbidden"] == {"stop": "", "task": "", "hand": UNKNOWN}


def test_what_was_heard_comes_with_its_age() -> None:
    task = Told(TaskStatus("carrying", 1.0, "following", 0.1, 0.9, None), 0.5)
    state = told({STATE_ROBOT.key: robot(True), TASK_STATUS.key: task, SIM_WORLD.key: world()})
    assert state["sentence"]["text"] == SENTENCE.text and state["sentence"]["kind"] == "held"
    assert 0 < len(state["sentence"]["more"]) < len(SENTENCE.more)
    assert state["gate"] == {"mode": "ready", "reason": "", "simulated": True, "require_enable": False, "age": 0.12}
    assert state["task"] == {"state": "carrying", "reason": "following", "age": 0.5}
    assert state["hand"]["wanted"] == [2.0, -0.3, 1.0] and state["hand"]["force"] == [3.0, 0.0, 4.0]
    assert (state["hand"]["doing"], state["hand"]["age"]) == ("guided", 0.01)
    assert state["forbidden"]["hand"] == ""


@pytest.mark.parametrize(
    ("known", "why"),
    [
        ({STATE_ROBOT.key: robot(False)}, ONLY_SIMULATED),
        ({STATE_ROBOT.key: robot(False), SIM_WORLD.key: world()}, ONLY_SIMULATED),
        ({STATE_ROBOT.key: robot(True), SIM_WORLD.key: world(None, None)}, NOBODY),
        ({STATE_ROBOT.key: robot(True), SIM_WORLD.key: world(PANEL, None)}, ""),
    ],
)
def test_hands_are_led_where_there_are_any(known: Known, why: str) -> None:
    assert told(known)["forbidden"]["hand"] == why


def test_a_certificate_s_reason_goes_before_the_scene_s() -> None:
    assert told({STATE_ROBOT.key: robot(False)}, hand="may not ask")["forbidden"]["hand"] == "may not ask"
