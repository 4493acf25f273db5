"""What a person may ask of the task: done, or refused with what to do instead."""

from __future__ import annotations

from dataclasses import dataclass, field

import pytest

from services.task.faults import TaskFault
from services.task.states import State
from shared.messages import GripperState
from tests.services.task.rig import MachineRig

FULL = GripperState(0.05, 10.0, True)
STOP = TaskFault("stop", "hand in the way")


@dataclass
class Case:
    """A command in a state, the words of its refusal, and what else is the case."""

    word: str
    state: State
    words: str
    parameters: dict[str, object] = field(default_factory=dict)
    changed: dict[str, object] = field(default_factory=dict)
    faults: tuple[TaskFault, ...] = ()


REFUSED = {
    "start twice": Case("start", State.SEARCHING, "at work already"),
    "start when done": Case("start", State.DONE, "`reset` first"),
    "start aborted": Case("start", State.HOLDING, "`reset` first"),
    "start with a full gripper": Case("start", State.IDLE, "`release` lets it go", changed={"gripper": FULL}),
    "start while stopped": Case("start", State.IDLE, "hand in the way", faults=(STOP,)),
    "start with too narrow a panel to be set down": Case(
        "start",
        State.IDLE,
        r"stands with the gripper at 0\.25 m.*reach_down, 0\.27 m.*0\.54 m wide",
        {"panel_width": 0.5},
    ),
    "start with too heavy a panel to be released": Case(
        "start",
        State.IDLE,
        r"weight is 12\.3 N.*limit of 10 N.*release_ramp",
        {"panel_mass": 2.5, "release_ramp": False},
    ),
    "reset at work": Case("reset", State.CARRYING, "`abort` first"),
    "release of nothing": Case("release", State.SEARCHING, "nothing is held"),
    "release while stopped": Case("release", State.CARRYING, "hand in the way", faults=(STOP,)),
}


@pytest.mark.parametrize("name", REFUSED)
def test_commands_are_refused_with_what_to_do_instead(name: str) -> None:
    case = REFUSED[name]
    play = MachineRig(**case.parameters).reach(case.state)
    if case.changed or case.faults:
        play.changed, play.faults = case.changed, list(case.faults)
        play.tick()
    held = play.toy.gripped
    play.refuses(case.word, case.words)
    play.run(1.0)
    assert play.toy.gripped == held


@pytest.mark.parametrize(
    "parameters", [{"panel_width": 0.6}, {"panel_mass": 2.5}, {"panel_mass": 2.0, "release_ramp": False}]
)
def test_a_panel_that_can_be_set_down_and_released_is_not_refused(parameters: dict[str, object]) -> None:
    assert MachineRig(**parameters).command("start") is State.IDLE


def test_carrying_on_after_an_abort_keeps_the_half_weight() -> None:
    play = MachineRig().lifted()
    play.command("abort")
    play.run(1.0)
    play.refuses("reset", "`release` lets it go")
    assert play.decision.nominal == pytest.approx(-play.settings.half_weight)
    play.halted("wrench_silent", "3 s old")
    play.refuses("start", "cannot carry on")
    play.faults = []
    play.tick()
    assert play.command("start") is State.CARRYING
    play.tick()
    assert play.decision.base and play.decision.nominal == pytest.approx(-play.settings.half_weight)


def test_release_by_word_waits_for_the_weight_and_a_second_word_that_is_no_double_click_opens() -> None:
    play = MachineRig().lifted()
    for _ in range(2):
        assert play.command("release") is State.RELEASING
    play.run(0.3)
    play.command("release")
    play.run(5.0)
    assert play.state is State.RELEASING and play.toy.gripped and "`release` again" in play.reason
    play.command("release")
    play.to(State.DONE)
    assert play.opened_in == {State.IDLE, State.RELEASING}


def test_release_by_word_of_a_panel_that_lies_takes_one_word() -> None:
    play = MachineRig().reach(State.CARRYING)
    play.command("release")
    play.to(State.DONE)


def test_what_the_gripper_holds_in_idle_is_let_go_by_the_same_rule() -> None:
    play = MachineRig()
    play.toy.gripped, play.toy.opening, play.toy.lifted = True, 0.05, True
    play.tick()
    play.refuses("start", "`release` lets it go")
    assert play.command("release") is State.RELEASING
    play.run(5.0)
    assert play.state is State.RELEASING and play.toy.gripped, "the robot carries half of it"
    play.toy.lifted = False
    play.to(State.DONE)
