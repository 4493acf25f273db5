"""Holding, and the ways out of it: what is held, how far it was turned, whose word opens the gripper."""

from __future__ import annotations

import math

import numpy as np
import pytest

from services.task.faults import TaskFault
from services.task.geometry import Pose
from services.task.states import State
from services.task.target import LEEWAY
from shared.messages import GripperState
from shared.parameters import Refused
from tests.services.task.play import Play
from tests.services.task.toy import START

EMPTY = GripperState(0.0, 0.0, False)


def lifted(**parameters: object) -> Play:
    """While carrying, with half the weight taken over."""
    play = Play(**parameters).reach(State.CARRYING)
    play.toy.lifted = True
    play.run(2.0)
    return play


def opened_by_word() -> Play:
    """While a person's second word has just begun to open the gripper."""
    play = lifted()
    play.machine.command("release")
    play.run(0.6)
    play.machine.command("release")
    play.tick()
    assert play.toy.wanted > 0.0
    return play


@pytest.mark.parametrize("held_before", [False, True])
def test_lost_from_the_gripper_it_holds_and_carries_nothing_by_agreement(held_before: bool) -> None:
    play = lifted()
    if held_before:
        play.machine.command("abort")
        play.run(0.5)
    assert play.decision.nominal == pytest.approx(-play.settings.half_weight)
    play.changed = {"gripper": EMPTY}
    play.run(0.5)
    assert play.state is State.HOLDING and "does not hold the panel any more" in play.machine.reason
    play.run(2.0)
    assert play.decision.nominal == 0.0
    with pytest.raises(Refused, match="`reset` begins anew"):
        play.machine.command("start")
    assert play.machine.command("reset") is State.IDLE


@pytest.mark.parametrize("first", ["fault", "release"])
@pytest.mark.parametrize(
    "name",
    ["untared", "unidentified", "wrench_invalid", "wrench_never", "controller_braking", "gripper_silent"],
)
def test_no_fault_of_a_sensor_keeps_the_panel_from_who_asks_twice(name: str, first: str) -> None:
    play = lifted()
    if first == "fault":
        play.faults = [TaskFault(name)]
        play.to(State.HOLDING, 5.0)
    assert play.machine.command("release") is State.RELEASING
    play.faults = [TaskFault(name)]
    if name.startswith("wrench"):
        play.changed = {"wrench": None}
    play.run(10.0)
    assert play.state is State.RELEASING and play.toy.gripped, "no force that is known, no opening"
    assert TaskFault(name).sentence in play.machine.reason and "`release` again opens" in play.machine.reason
    play.machine.command("release")
    play.run(5.0)
    assert not play.toy.gripped and play.opened_in == {State.IDLE, State.RELEASING}


@pytest.mark.parametrize("cause", ["stop", "abort"])
@pytest.mark.parametrize("held", [True, False])
def test_an_opening_that_is_interrupted_stops(cause: str, held: bool) -> None:
    play = opened_by_word()
    if not held:
        play.run(0.2)
    # The toy lets go with the first tenth of a millimetre; the fingers of a robot press on foam.
    play.changed = {"gripper": GripperState(play.toy.opening, 9.0, True)} if held else {}
    if cause == "stop":
        play.faults = [TaskFault("stop", "hand in the way")]
        play.tick()
    else:
        play.machine.command("abort")
    where = play.toy.opening
    play.tick()
    assert play.state is State.HOLDING and play.machine.fingers.hold == held
    assert play.toy.wanted == (0.0 if held else pytest.approx(where, abs=0.003))
    play.faults = []
    play.run(2.0)
    assert play.toy.opening <= where + 0.003, "nor when the stop is released"
    assert play.opened_in <= {State.IDLE, State.RELEASING}
    if held:
        with pytest.raises(Refused, match="holds something"):
            play.machine.command("reset")
        assert play.machine.command("start") is State.CARRYING
    else:
        assert play.machine.command("reset") is State.IDLE
        assert play.machine.command("start") is State.IDLE
        play.to(State.CALIBRATING)


def test_an_opening_that_is_interrupted_stops_once_the_gripper_is_known() -> None:
    play = opened_by_word()
    play.changed = {"gripper": None}
    play.tick()
    play.machine.command("abort")
    play.tick()
    assert play.decision.gripper is None
    with pytest.raises(Refused, match="holds something"):
        play.machine.command("reset")
    play.changed = {"gripper": GripperState(0.05, 9.0, True)}
    play.tick()
    assert play.machine.fingers.hold and play.decision.gripper.opening == 0.0


def test_abort_stops_fingers_that_open_in_idle() -> None:
    play = Play()
    play.machine.command("start")
    play.run(0.1)
    play.machine.command("abort")
    play.tick()
    where = play.toy.opening
    assert play.toy.wanted == pytest.approx(where, abs=0.003)


@pytest.mark.parametrize("word", ["start", "release"])
def test_a_stop_breaks_off_an_opening_in_idle(word: str) -> None:
    play = Play()
    play.machine.command(word)
    play.run(0.1)
    play.faults = [TaskFault("stop", "hand in the way")]
    play.tick()
    where = play.toy.opening
    assert "broken off (stop is engaged (hand in the way))" in play.machine.reason
    with pytest.raises(Refused, match="hand in the way"):
        play.machine.command(word)
    play.faults = []
    play.run(1.0)
    assert play.state is State.IDLE and play.toy.opening == pytest.approx(where, abs=0.003)
    play.machine.command(word)
    play.run(1.0)
    assert play.toy.opening > 0.05


def turned_by(play: Play, degrees: float) -> None:
    """The person turns the panel until it is turned that far since the grasp, whatever the task thinks."""
    play.toy.roll_rate = 0.2
    play.run(20.0, lambda: play.toy.tool.rpy[0] >= math.radians(degrees) + START.rpy[0])
    play.toy.roll_rate = 0.0
    assert math.degrees(play.toy.tool.rpy[0] - START.rpy[0]) == pytest.approx(degrees, abs=1.0)


def test_carrying_on_remembers_how_far_the_panel_was_turned() -> None:
    play = lifted()
    turned_by(play, 45.0)
    play.machine.command("abort")
    play.run(0.5)
    play.machine.command("start")
    play.tick()
    assert math.degrees(play.machine.rotation) == pytest.approx(45.0, abs=1.0)
    turned_by(play, 80.0)
    play.tick()
    assert play.decision.target.rpy[0] == pytest.approx(START.rpy[0] + math.pi / 2, abs=1.01 * LEEWAY), (
        "it snaps"
    )
    play.toy.far_height = play.toy.stands
    play.to(State.DONE)
    assert math.degrees(play.toy.tool.rpy[0] - START.rpy[0]) == pytest.approx(90.0, abs=16.0)


def test_carrying_on_needs_a_gripper_that_holds_now() -> None:
    play = lifted()
    play.machine.command("abort")
    play.changed = {"gripper": EMPTY}
    play.tick()
    with pytest.raises(Refused, match="the gripper holds nothing"):
        play.machine.command("start")
    play.changed = {"gripper": None}
    play.tick()
    with pytest.raises(Refused, match="state/gripper is silent"):
        play.machine.command("start")
    play.changed = {}
    play.tick()
    assert play.machine.command("start") is State.CARRYING


def test_a_silent_gripper_stops_the_base_and_is_waited_for() -> None:
    play = lifted()
    play.changed = {"gripper": None}
    play.tick()
    assert not play.decision.base and "state/gripper" in play.machine.reason
    play.run(2.5)
    assert play.state is State.CARRYING
    assert play.decision.nominal == pytest.approx(-play.settings.half_weight), "not to know is no loss"
    play.run(1.0)
    assert play.state is State.HOLDING and "state/gripper" in play.machine.reason
    assert play.decision.gripper is not None and play.decision.gripper.opening == 0.0


def test_a_robot_that_was_restarted_meanwhile_is_not_sent_back() -> None:
    play = lifted()
    play.machine.command("abort")
    play.run(0.5)
    elsewhere = Pose(play.toy.tool.position + np.array((0.0, 0.1, 0.25)), play.toy.tool.rotation)
    play.toy.tool, play.toy.session = elsewhere, 2
    assert play.tick().target.near(elsewhere, 1e-9, 1e-9)
    play.run(2.0)
    assert play.state is State.HOLDING and play.toy.tool.near(elsewhere, 0.005, 0.01)


def test_a_tool_that_points_down_is_not_carried_on_with() -> None:
    play = lifted()
    play.machine.command("abort")
    play.tick()
    play.changed = {"tool": play.toy.tool @ Pose.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, math.radians(40)))}
    play.tick()
    with pytest.raises(Refused, match=r"the tool points (up|down) by 40 degrees, allowed are 30"):
        play.machine.command("start")


def test_carrying_on_it_has_the_same_home_although_the_tool_was_pulled_away_meanwhile() -> None:
    """With the arm stretched it could not set the panel down."""
    play = lifted()
    home = play.machine.entry(None).home_pose
    play.machine.command("abort")
    play.tick()
    play.toy.tool = Pose(play.toy.tool.position + np.array((0.15, 0.0, 0.0)), play.toy.tool.rotation)
    play.tick()
    play.machine.command("start")
    assert play.tick().target.position[:2] == pytest.approx(home.position[:2])
