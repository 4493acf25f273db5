"""On the way to the grasp: which panel is gone to, how the target leads the tool, and when the gripper closes."""

from __future__ import annotations

import numpy as np
import pytest

from services.task.faults import TaskFault
from services.task.geometry import Pose
from services.task.states import State
from tests.services.task.rig import MachineRig
from tests.services.task.toy import MARKER


def turned(roll: float = 0.0, pitch: float = 0.0, yaw: float = 0.0) -> Pose:
    """The marker, turned in base about its place by so many degrees."""
    return Pose(MARKER.position, (Pose.from_rpy((0, 0, 0), np.radians((roll, pitch, yaw))) @ MARKER).rotation)


ANYWHERE = {"reach_low": (-2.0,) * 3, "reach_high": (2.0,) * 3}
NEARER = Pose(MARKER.position - (0.12, 0.0, 0.0), MARKER.rotation)
NOT_GONE_TO = {
    "too steep up": (
        ANYWHERE,
        turned(pitch=-80.0),
        "too steep: the tool points up by 80 degrees, allowed are 30; lay it flatter",
        turned(pitch=20.0),
    ),
    "too steep down": (
        ANYWHERE,
        turned(pitch=40.0),
        "too steep: the tool points down by 40 degrees",
        turned(pitch=20.0),
    ),
    "turned away": (ANYWHERE, turned(yaw=180.0), "its far side", turned(pitch=20.0)),
    "out of reach": (
        {"reach_high": (0.5, 0.2, 1.2)},
        MARKER,
        "out of reach: x is 0.60 m, within reach is 0.35 to 0.5 m; move the panel or the robot, if its black square",
        NEARER,
    ),
}


@pytest.mark.parametrize("name", NOT_GONE_TO)
def test_a_panel_that_cannot_be_carried_from_there_is_told_and_not_gone_to(name: str) -> None:
    parameters, marker, words, mended = NOT_GONE_TO[name]
    play = MachineRig(**parameters)
    play.toy.marker = marker
    play.reach(State.SEARCHING)
    play.run(3.0)
    assert play.state is State.SEARCHING and words in play.reason
    play.toy.marker = mended
    play.to(State.APPROACHING, 3.0)


def going_in() -> MachineRig:
    """On the last, straight part of the way."""
    play = MachineRig().reach(State.APPROACHING)
    play.run(20.0, lambda: "going in" in play.reason)
    play.run(0.5)
    return play


def ahead(play: MachineRig) -> float:
    """How far [m] the target is ahead of the tool along the way in."""
    tool, target = play.toy.tool, play.decision.target
    assert target is not None
    return float((target.position - tool.position) @ tool.rotation[:, 0])


def test_what_is_in_the_way_is_pressed_no_harder_by_waiting_longer() -> None:
    play = going_in()
    stuck = play.toy.tool
    for _ in range(500):
        play.tick()
        play.toy.tool = stuck
    assert play.state is State.APPROACHING and 0.05 < ahead(play) < 0.11


def test_it_does_not_go_in_from_the_side_or_askew() -> None:
    for offset in (Pose.from_rpy((0.0, 0.0, 0.04), (0.0,) * 3), Pose.from_rpy((0.0,) * 3, (0.0, 0.0, 0.2))):
        play = MachineRig().reach(State.APPROACHING)
        play.run(20.0, lambda play=play: "going in" in play.reason)
        held = play.toy.tool @ offset
        for _ in range(200):
            play.toy.tool = held
            play.tick()
        assert ahead(play) < 0.03, "it waits for the tool to be in line"


def test_a_panel_that_was_moved_aside_is_gone_to_anew() -> None:
    play = going_in()
    play.toy.marker = Pose(MARKER.position + np.array((0.0, 0.08, 0.0)), MARKER.rotation)
    target = play.tick().target
    assert target is not None
    grasp = play.toy.marker @ Pose.from_rpy(play.settings.grasp_position, play.settings.grasp_rpy)
    assert target.near(grasp.shifted(-play.settings.standoff), 0.005, 0.01), "back to the point before it"


def test_a_touch_before_the_grasp_ends_the_approach_and_names_the_size_of_the_marker() -> None:
    play = going_in()
    play.changed = {"wrench": np.array((0.0, 2.0, 2.0, 0.0, 0.0, 0.0))}
    play.run(1.0)
    assert play.state is State.APPROACHING, "no more than a free tool may feel"
    play.changed = {"wrench": np.array((0.0, 0.0, 4.0, 0.0, 0.0, 0.0))}
    play.run(0.2)
    assert play.state is State.APPROACHING, "a bump"
    play.run(0.2)
    assert play.state is State.HOLDING
    assert "touched something" in play.reason and "4.0 N, allowed are 3 N" in play.reason
    assert "marker_size, grasp_position" in play.reason


def test_what_a_tare_leaves_in_another_attitude_is_no_touch() -> None:
    play = MachineRig().reach(State.APPROACHING)
    play.changed = {"wrench": np.array((0.0, 6.0, -5.0, 0.0, 0.0, 0.0))}
    play.to(State.GRASPING)


@pytest.mark.parametrize("moving", [{"speed": 0.05}, {"turning": 0.05}])
def test_the_gripper_does_not_close_while_the_tool_moves(moving: dict[str, float]) -> None:
    play = going_in()
    play.changed = moving
    play.run(10.0)
    assert play.state is State.APPROACHING and play.toy.tool.near(play.toy.grasp, 0.01, 0.05)
    play.changed = {}
    play.to(State.GRASPING, 1.0)


def test_an_arm_that_may_hide_the_panel_is_taken_out_of_the_picture_once_the_head_has_looked_all_around() -> None:
    play = MachineRig()
    lookout = Pose.from_rpy(play.settings.lookout_position, play.settings.lookout_rpy)
    play.toy.marker, play.changed = None, {"doubt": TaskFault("marker_missing")}
    play.reach(State.SEARCHING)
    where = play.toy.tool
    play.run(7.9)
    assert play.toy.tool.near(where, 1e-3, 1e-3), "at first the head alone looks around"
    play.run(10.0)
    assert play.state is State.SEARCHING and play.toy.tool.near(lookout, 0.03, 0.1)
    assert "lookout" not in play.reason and "covered" in play.reason
    play.toy.marker, play.changed = MARKER, {}
    play.to(State.CARRYING)


def test_an_arm_in_the_lookout_pose_stands_while_the_marker_is_covered() -> None:
    play = MachineRig()
    play.toy.tool = Pose.from_rpy(play.settings.lookout_position, play.settings.lookout_rpy)
    play.toy.marker, play.changed = None, {"doubt": TaskFault("marker_missing")}
    play.reach(State.SEARCHING)
    where = play.toy.tool
    play.run(30.0)
    assert play.state is State.SEARCHING and play.toy.tool.near(where, 1e-6, 1e-6)
