"""Fingers that were opening stay where they are, whatever ends the opening and however often it is ended."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from services.task.faults import TaskFault
from services.task.states import State
from shared.messages import GripperState
from shared.parameters import Refused
from tests.services.task.play import Play

STOP = TaskFault("stop", "hand in the way")
STILL = 0.003  # [m]: what a step and a half of opening is


def opening(state: State) -> Play:
    """Fingers half-way between the panel and open, in idle or releasing."""
    if state is State.IDLE:
        play = Play()
        play.machine.command("start")
    else:
        play = Play().reach(State.CARRYING)
        play.machine.command("release")
        play.run(3.0, lambda: play.toy.wanted > 0.0)
    play.run(0.1)
    assert play.state is state and play.toy.wanted > play.toy.opening + 0.01
    return play


def abort(play: Play) -> None:
    play.machine.command("abort")


def abort_twice(play: Play) -> None:
    abort(play)
    abort(play)


def abort_after_a_stop(play: Play) -> None:
    play.faults = [STOP]
    play.tick()
    abort(play)


def stop_out_of_sight(play: Play) -> None:
    play.faults, play.changed = [STOP], {"gripper": None}
    play.tick()
    play.faults, play.changed = [], {}


def abort_out_of_sight(play: Play) -> None:
    play.faults = [TaskFault("tool", "state/ee is silent")]
    play.tick(lost=True)
    abort_twice(play)
    play.faults = []


def abort_and_reset(play: Play) -> None:
    abort(play)
    play.machine.command("reset")


ENDS = (abort, abort_twice, abort_after_a_stop, stop_out_of_sight, abort_out_of_sight, abort_and_reset)


@pytest.mark.parametrize("state", [State.IDLE, State.RELEASING])
@pytest.mark.parametrize("end", ENDS)
def test_whatever_ends_it_they_stay(state: State, end: Callable[[Play], None]) -> None:
    play = opening(state)
    end(play)
    play.tick()
    where = play.toy.opening
    play.run(5.0)
    assert play.state in (State.HOLDING, State.IDLE)
    assert play.toy.opening == pytest.approx(where, abs=STILL)
    assert play.opened_in <= {State.IDLE, State.RELEASING}


def test_an_opening_in_idle_is_reset() -> None:
    play = opening(State.IDLE)
    assert play.machine.command("reset") is State.IDLE
    play.tick()
    where = play.toy.opening
    play.run(5.0)
    assert play.toy.opening == pytest.approx(where, abs=STILL)


def test_fingers_that_do_not_open_are_not_left_to_open_later() -> None:
    play = Play()
    stuck = play.toy.opening
    play.machine.command("start")
    play.run(10.0, lambda: setattr(play.toy, "opening", stuck) or "look at it" in play.machine.reason)
    assert "look at it" in play.machine.reason
    play.run(2.0)
    assert play.toy.opening == pytest.approx(stuck, abs=STILL)


def test_the_step_that_enters_holding_tells_them_already() -> None:
    play = opening(State.RELEASING)
    where = play.toy.opening
    play.faults = [STOP]
    decision = play.tick()
    assert play.state is State.HOLDING and decision.gripper is not None
    assert decision.gripper.opening == pytest.approx(where, abs=STILL)


def test_two_words_within_one_step_do_not_open_the_gripper() -> None:
    play = Play().reach(State.CARRYING)
    play.toy.lifted = True
    play.run(2.0)
    for _ in range(2):
        assert play.machine.command("release") is State.RELEASING
    play.run(0.3)
    play.machine.command("release")
    play.run(5.0)
    assert play.state is State.RELEASING and play.toy.gripped
    play.machine.command("release")
    play.to(State.DONE)


def test_what_the_gripper_holds_in_idle_is_let_go_by_the_same_rule() -> None:
    play = Play()
    play.toy.gripped, play.toy.opening, play.toy.lifted = True, 0.05, True
    play.tick()
    with pytest.raises(Refused, match="`release` lets it go"):
        play.machine.command("start")
    assert play.machine.command("release") is State.RELEASING
    play.run(5.0)
    assert play.state is State.RELEASING and play.toy.gripped, "the robot carries half of it"
    play.toy.lifted = False
    play.to(State.DONE)


def test_release_is_refused_while_stopped() -> None:
    play = Play().reach(State.CARRYING)
    play.faults = [STOP]
    play.tick()
    with pytest.raises(Refused, match="hand in the way"):
        play.machine.command("release")
    play.run(1.0)
    assert play.state is State.HOLDING and play.toy.gripped


def test_a_failed_grasp_is_not_carried_on_with() -> None:
    play = Play().reach(State.GRASPING)
    play.changed = {"gripper": GripperState(0.012, 12.0, True)}
    play.to(State.HOLDING, 10.0)
    with pytest.raises(Refused, match="cannot carry on: the grasp failed: it is 12 mm wide, the panel 50 mm"):
        play.machine.command("start")
    play.changed = {}
    play.run(0.1)
    assert play.machine.command("start") is State.CARRYING, "the panel itself is"
