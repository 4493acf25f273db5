"""Fingers that were opening stay where they are, whatever ends the opening and however often it is ended."""

from __future__ import annotations

import pytest

from services.task.faults import TaskFault
from services.task.states import State
from shared.messages import GripperState
from tests.services.task.rig import MachineRig

STOP = TaskFault("stop", "hand in the way")
STILL = 0.003  # [m]: what a step and a half of opening is


def opening(state: State) -> MachineRig:
    """Fingers half-way between the panel and open, in idle or releasing."""
    if state is State.IDLE:
        play = MachineRig()
        play.command("start")
    else:
        play = MachineRig().reach(State.CARRYING)
        play.command("release")
        play.run(3.0, lambda: play.toy.wanted > 0.0)
    play.run(0.1)
    assert play.state is state and play.toy.wanted > play.toy.opening + 0.01
    return play


def stay(play: MachineRig) -> bool:
    """Whether the fingers, a step from now, are where they are for good."""
    play.tick()
    where = play.toy.opening
    play.run(5.0)
    return play.toy.opening == pytest.approx(where, abs=STILL)


def do(play: MachineRig, what: str) -> None:
    """Say something, or have a step go wrong."""
    if what in ("abort", "reset"):
        play.command(what)
        return
    play.faults = [TaskFault("tool", "state/ee is silent") if what == "pose lost" else STOP]
    play.changed = {"gripper": None} if what == "stop out of sight" else {}
    play.tick(lost=what == "pose lost")
    if what != "stop":
        play.faults, play.changed = [], {}


ENDS = ("abort", "abort, abort", "stop, abort", "stop out of sight", "pose lost, abort, abort", "abort, reset")


@pytest.mark.parametrize(
    ("state", "ends"),
    [(state, ends) for state in (State.IDLE, State.RELEASING) for ends in ENDS] + [(State.IDLE, "reset")],
)
def test_whatever_ends_it_they_stay(state: State, ends: str) -> None:
    play = opening(state)
    for end in ends.split(", "):
        do(play, end)
    assert stay(play)
    assert play.state in (State.HOLDING, State.IDLE)
    assert play.opened_in <= {State.IDLE, State.RELEASING}


@pytest.mark.parametrize("word", ["start", "release"])
def test_a_stop_breaks_off_an_opening_in_idle(word: str) -> None:
    play = MachineRig()
    play.command(word)
    play.run(0.1)
    play.halted("stop", "hand in the way")
    where = play.toy.opening
    assert "broken off (stop is engaged (hand in the way))" in play.reason
    play.refuses(word, "hand in the way")
    play.faults = []
    assert stay(play) and play.state is State.IDLE and play.toy.opening == pytest.approx(where, abs=STILL)
    play.command(word)
    play.run(1.0)
    assert play.toy.opening > 0.05


def opened_by_word() -> MachineRig:
    """While a person's second word has just begun to open the gripper."""
    play = MachineRig().lifted()
    play.command("release")
    play.run(0.6)
    play.command("release")
    play.tick()
    assert play.toy.wanted > 0.0
    return play


@pytest.mark.parametrize("cause", ["stop", "abort"])
@pytest.mark.parametrize("held", [True, False])
def test_they_close_on_what_they_still_hold(cause: str, held: bool) -> None:
    play = opened_by_word()
    if not held:
        play.run(0.2)
    # The toy lets go with the first tenth of a millimetre; the fingers of a robot press on foam.
    play.changed = {"gripper": GripperState(play.toy.opening, 9.0, True)} if held else {}
    if cause == "stop":
        play.halted("stop", "hand in the way")
    else:
        play.command("abort")
    where = play.toy.opening
    play.tick()
    assert play.state is State.HOLDING and play.machine.fingers.hold == held
    assert play.toy.wanted == (0.0 if held else pytest.approx(where, abs=STILL))
    play.faults = []
    play.run(2.0)
    assert play.toy.opening <= where + STILL, "nor when the stop is released"
    assert play.opened_in <= {State.IDLE, State.RELEASING}
    if held:
        play.refuses("reset", "holds something")
        assert play.command("start") is State.CARRYING
    else:
        assert play.command("reset") is State.IDLE
        assert play.command("start") is State.IDLE
        play.to(State.CALIBRATING)


def test_they_close_on_it_as_soon_as_the_gripper_is_known() -> None:
    play = opened_by_word()
    play.changed = {"gripper": None}
    play.tick()
    play.command("abort")
    play.tick()
    assert play.decision.gripper is None
    play.refuses("reset", "holds something")
    play.changed = {"gripper": GripperState(0.05, 9.0, True)}
    play.tick()
    assert play.machine.fingers.hold and play.decision.gripper.opening == 0.0


def test_fingers_that_do_not_open_are_not_left_to_open_later() -> None:
    play = MachineRig()
    stuck = play.toy.opening
    play.command("start")
    play.run(10.0, lambda: setattr(play.toy, "opening", stuck) or "look at it" in play.reason)
    assert "look at it" in play.reason
    play.run(2.0)
    assert play.toy.opening == pytest.approx(stuck, abs=STILL)


def test_the_step_that_enters_holding_tells_them_already() -> None:
    play = opening(State.RELEASING)
    where = play.toy.opening
    play.faults = [STOP]
    decision = play.tick()
    assert play.state is State.HOLDING and decision.gripper is not None
    assert decision.gripper.opening == pytest.approx(where, abs=STILL)
