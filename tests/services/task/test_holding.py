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
from tests.services.task.rig import MachineRig
from tests.services.task.toy import START

EMPTY = GripperState(0.0, 0.0, False)


@pytest.mark.parametrize("held_before", [False, True])
def test_lost_from_the_gripper_it_holds_and_carries_nothing_by_agreement(held_before: bool) -> None:
    play = MachineRig().lifted()
    if held_before:
        play.command("abort")
        play.run(0.5)
    assert play.decision.nominal == pytest.approx(-play.settings.half_weight)
    play.changed = {"gripper": EMPTY}
    play.run(0.5)
    assert play.state is State.HOLDING and "does not hold the panel any more" in play.reason
    play.run(2.0)
    assert play.decision.nominal == 0.0
    play.refuses("start", "`reset` begins anew")
    assert play.command("reset") is State.IDLE


@pytest.mark.parametrize("first", ["fault", "release"])
@pytest.mark.parametrize(
    "name", ["untared", "unidentified", "wrench_invalid", "wrench_never", "controller_braking", "gripper_silent"]
)
def test_no_fault_of_a_sensor_keeps_the_panel_from_who_asks_twice(name: str, first: str) -> None:
    play = MachineRig().lifted()
    if first == "fault":
        play.faults = [TaskFault(name)]
        play.to(State.HOLDING, 5.0)
    assert play.command("release") is State.RELEASING
    play.faults = [TaskFault(name)]
    if name.startswith("wrench"):
        play.changed = {"wrench": None}
    play.run(10.0)
    assert play.state is State.RELEASING and play.toy.gripped, "no force that is known, no opening"
    assert TaskFault(name).sentence in play.reason and "`release` again opens" in play.reason
    play.command("release")
    play.run(5.0)
    assert not play.toy.gripped and play.opened_in == {State.IDLE, State.RELEASING}


def turned_by(play: MachineRig, degrees: float) -> None:
    """The person turns the panel until it is turned that far since the grasp, whatever the task thinks."""
    play.toy.roll_rate = 0.2
    play.run(20.0, lambda: play.toy.tool.rpy[0] >= math.radians(degrees) + START.rpy[0])
    play.toy.roll_rate = 0.0
    assert math.degrees(play.toy.tool.rpy[0] - START.rpy[0]) == pytest.approx(degrees, abs=1.0)


def test_carrying_on_remembers_how_far_the_panel_was_turned() -> None:
    play = MachineRig().lifted()
    turned_by(play, 45.0)
    play.command("abort")
    play.run(0.5)
    play.command("start")
    play.tick()
    assert math.degrees(play.machine.rotation) == pytest.approx(45.0, abs=1.0)
    turned_by(play, 80.0)
    play.tick()
    assert play.decision.target.rpy[0] == pytest.approx(START.rpy[0] + math.pi / 2, abs=1.01 * LEEWAY), "it snaps"
    play.toy.far_height = play.toy.stands
    play.to(State.DONE)
    assert math.degrees(play.toy.tool.rpy[0] - START.rpy[0]) == pytest.approx(90.0, abs=16.0)


def test_a_silent_gripper_stops_the_base_and_is_waited_for() -> None:
    play = MachineRig().lifted()
    play.changed = {"gripper": None}
    play.tick()
    assert not play.decision.base and "state/gripper" in play.reason
    play.run(2.5)
    assert play.state is State.CARRYING
    assert play.decision.nominal == pytest.approx(-play.settings.half_weight), "not to know is no loss"
    play.run(1.0)
    assert play.state is State.HOLDING and "state/gripper" in play.reason
    assert play.decision.gripper is not None and play.decision.gripper.opening == 0.0


STEEP = START @ Pose.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, math.radians(40)))
NOT_ON = {
    "empty": ({"gripper": EMPTY}, "the gripper holds nothing"),
    "not known": ({"gripper": None}, "state/gripper was never received"),
    "steep": ({"tool": STEEP}, r"the tool points (up|down) by 40 degrees, allowed are 30"),
}


@pytest.mark.parametrize("name", NOT_ON)
def test_carrying_on_needs_a_gripper_that_holds_now_and_a_tool_that_is_level(name: str) -> None:
    changed, words = NOT_ON[name]
    play = MachineRig().lifted()
    play.command("abort")
    play.changed = changed
    play.tick()
    play.refuses("start", words)
    play.changed = {}
    play.tick()
    assert play.command("start") is State.CARRYING


def test_a_failed_grasp_is_not_carried_on_with() -> None:
    play = MachineRig().reach(State.GRASPING)
    play.changed = {"gripper": GripperState(0.012, 12.0, True)}
    play.to(State.HOLDING, 10.0)
    play.refuses("start", "cannot carry on: the grasp failed: it is 12 mm wide, the panel 50 mm")
    play.changed = {}
    play.run(0.1)
    assert play.command("start") is State.CARRYING, "the panel itself is"


def test_carrying_on_it_has_the_same_home_although_the_tool_was_pulled_away_meanwhile() -> None:
    """With the arm stretched it could not set the panel down."""
    play = MachineRig().lifted()
    home = play.machine.entry(None).home_pose
    play.command("abort")
    play.tick()
    play.toy.tool = Pose(play.toy.tool.position + np.array((0.15, 0.0, 0.0)), play.toy.tool.rotation)
    play.tick()
    play.command("start")
    assert play.tick().target.position[:2] == pytest.approx(home.position[:2])
