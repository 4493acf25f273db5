"""The state machine: a whole carry, each refusal and each reaction, without bus and clock."""

from __future__ import annotations

import math

import numpy as np
import pytest

from services.task.faults import FAULTS, Impairment, TaskFault
from services.task.geometry import Pose
from services.task.parameters import TaskParameters
from services.task.states import REACTIONS, State
from shared.spatial import rotation_from_vector
from tests.services.task.rig import DT, ORDER, MachineRig
from tests.services.task.toy import MARKER


def test_a_whole_carry() -> None:
    play = MachineRig().reach(State.DONE)
    assert play.states == ORDER
    assert play.opened_in == {State.IDLE, State.RELEASING}
    assert not play.toy.gripped and play.toy.opening > 0.05
    assert play.machine.rotation == pytest.approx(math.pi / 2, abs=0.3)
    assert play.toy.tool.position[2] == pytest.approx(play.settings.standing_height, abs=0.02)


def test_target_of_the_paper_does_not_follow() -> None:
    play = MachineRig(fixed_target=True).reach(State.CARRYING)
    home = play.toy.tool
    play.toy.lifted, play.toy.roll_rate = True, 0.3
    play.run(2.0)
    assert play.decision.target.near(home, 1e-9, 1e-6)
    assert play.decision.nominal == pytest.approx(-play.settings.half_weight)


@pytest.mark.parametrize(("assist", "follows"), [(0.0, 0.0), (1.0, 0.2)])
def test_with_level_assist_alone_the_tool_follows_the_far_end_down(assist: float, follows: float) -> None:
    play = MachineRig(level_assist=assist).reach(State.CARRYING)
    home = float(play.toy.tool.position[2])
    play.toy.lifted, play.toy.far_height = True, home - 0.2
    play.run(5.0)
    assert play.toy.tool.position[2] == pytest.approx(home - follows, abs=0.02)
    assert assist or play.decision.target.position[2] == pytest.approx(home, abs=1e-3)


def test_nominal_is_zero_before_the_lift_and_fades_in_the_release() -> None:
    play = MachineRig().reach(State.CARRYING)
    play.run(1.0)
    assert play.decision.nominal == 0.0 and "lift the panel" in play.reason
    play.toy.lifted = True
    play.run(1.0)
    assert play.decision.nominal == pytest.approx(-play.settings.half_weight)
    play = MachineRig().reach(State.RELEASING)
    play.run(1.6)
    assert play.decision.nominal == 0.0


def test_who_lifts_a_panel_that_the_gripper_cannot_hold_alone_is_told_so() -> None:
    light, heavy = (MachineRig(panel_mass=mass).reach(State.CARRYING) for mass in (1.5, 2.5))
    for play in (light, heavy):
        play.run(0.2)
    assert "let go" not in light.reason
    assert "do not let go of the panel before it stands: its 15 Nm would tear it" in heavy.reason


def test_a_panel_that_was_never_lifted_is_not_let_go() -> None:
    play = MachineRig(ground_height=0.5).reach(State.CARRYING)
    play.toy.roll_rate = 0.2
    play.run(20.0, lambda: play.machine.rotation > 1.5)
    play.toy.roll_rate = 0.0
    play.run(5.0)
    assert play.state is State.CARRYING


def test_turned_back_while_set_down_it_is_carried_on() -> None:
    play = MachineRig().reach(State.RELEASING)
    play.toy.stands, play.toy.lifted = 0.0, True
    play.toy.roll_rate = -0.8
    play.to(State.CARRYING, 3.0)
    assert play.toy.gripped and "carrying on" in play.reason


def test_a_panel_on_the_ground_is_neither_dragged_home_nor_pressed_upright() -> None:
    play = MachineRig().reach(State.RELEASING)
    home = play.machine.entry(None).home_pose
    tool = play.toy.tool
    aside = np.array((0.04, -0.05, 0.0))
    play.toy.tool = tool = Pose(
        tool.position + aside, rotation_from_vector((0.0, 0.0, 0.1)) @ tool.rotation
    ) @ Pose.from_rpy((0, 0, 0), (math.radians(5), 0, 0))
    for _ in range(10):
        target = play.tick().target
        assert target.position[:2] == pytest.approx(tool.position[:2], abs=1e-9)
        assert target.angle(tool) < 0.01
    play.toy.stands, play.toy.roll_rate = 0.0, -0.8
    play.to(State.CARRYING, 3.0)
    target = play.tick().target
    assert target.position[:2] == pytest.approx(home.position[:2], abs=1e-9), "while it is carried, that is home"
    assert target.rpy[2] == pytest.approx(home.rpy[2], abs=1e-9)


def test_base_is_enabled_while_carrying_only() -> None:
    play = MachineRig()
    play.command("start")
    for _ in range(4000):
        decision = play.tick()
        assert not decision.base or play.state is State.CARRYING
        play.toy.lifted |= play.state is State.CARRYING
    assert play.state is State.CARRYING and play.decision.base


@pytest.mark.parametrize("state", ORDER)
def test_abort_from_everywhere_keeps_the_grip(state: State) -> None:
    play = MachineRig().reach(state)
    held = play.machine.fingers.hold
    assert play.command("abort") is State.HOLDING
    where = play.toy.tool
    play.run(5.0)
    assert play.state is State.HOLDING and play.machine.fingers.hold == held
    assert play.toy.tool.near(where, 0.01, 0.05)
    assert not play.decision.base and (play.decision.gripper is None) == (not held)


@pytest.mark.parametrize("state", list(REACTIONS))
@pytest.mark.parametrize("name", [name for name, (kind, _) in FAULTS.items() if kind is not Impairment.BLIND])
def test_faults_by_their_kind(state: State, name: str) -> None:
    play = MachineRig().reach(state)
    held, kind = play.machine.fingers.hold, TaskFault(name).kind
    play.faults = [TaskFault(name)]
    play.tick()
    reaction = REACTIONS[state].get(kind)
    if reaction is None:
        assert play.state is not State.HOLDING
        return
    assert (play.state is State.HOLDING) == (reaction == "now")
    assert TaskFault(name).sentence in play.reason
    play.run(10.0)
    assert (play.state is State.HOLDING) == (reaction != "forever")
    assert play.machine.fingers.hold == held, "whatever was held is held"


def test_a_short_fault_is_waited_for_at_the_spot() -> None:
    play = MachineRig().lifted()
    nominal, where = play.decision.nominal, play.toy.tool
    play.faults = [TaskFault("wrench_silent", "2.0 s old")]
    play.run(2.0)
    assert play.state is State.CARRYING and not play.decision.base
    assert play.decision.target.near(where, 0.01, 0.05) and play.decision.nominal == nominal
    play.faults = []
    play.run(0.5)
    assert play.state is State.CARRYING and play.decision.base


def test_without_the_tool_s_pose_the_last_target_stays() -> None:
    play = MachineRig().reach(State.CARRYING)
    play.faults = [TaskFault("tool", "state/ee is silent")]
    for _ in range(100):
        assert play.tick(lost=True).target is None
    assert play.state is State.CARRYING
    for _ in range(100):
        play.tick(lost=True)
    assert play.state is State.HOLDING
    play.faults = []
    where = play.toy.tool
    play.run(1.0)
    assert play.decision.target.near(where, 0.02, 0.05)


def test_a_pose_that_comes_back_while_it_waits_is_where_it_stands() -> None:
    play = MachineRig().reach(State.APPROACHING)
    play.run(0.5)
    play.faults = [TaskFault("tool", "state/ee is silent")]
    for _ in range(5):
        play.tick(lost=True)
    where = play.toy.tool
    play.toy.marker, play.faults = None, [TaskFault("marker_missing")]
    play.run(2.0)
    assert play.state is State.APPROACHING and "covered" in play.reason
    assert play.toy.tool.near(where, 0.01, 0.05), "it does not go on to the last target"


@pytest.mark.parametrize("state", [State.SEARCHING, State.APPROACHING])
def test_a_covered_marker_makes_it_wait_and_say_why_then_give_up(state: State) -> None:
    play = MachineRig()
    play.changed = {"doubt": TaskFault("marker_missing")}
    if state is State.SEARCHING:
        play.toy.marker = None
    play.reach(state)
    play.run(0.5)
    play.toy.marker, play.faults = None, [TaskFault("marker_missing")]
    where = play.toy.tool
    play.run(3.0)
    assert play.state is state and "covered" in play.reason
    assert play.toy.tool.near(where, 0.01, 0.05), "it does not move"
    play.run(70.0)
    assert play.state is State.HOLDING and "covered" in play.reason


@pytest.mark.parametrize(
    ("state", "remedy"), [(State.CARRYING, "`start` carries on"), (State.APPROACHING, "`reset` begins anew")]
)
def test_holding_says_what_to_do_once_its_cause_is_gone(state: State, remedy: str) -> None:
    play = MachineRig().reach(state)
    play.faults = [TaskFault("stop", "red button")]
    play.run(0.5)
    assert play.state is State.HOLDING
    assert play.reason == "stop is engaged (red button): `tandem resume` releases it"
    play.faults = []
    play.run(0.5)
    assert play.state is State.HOLDING
    assert play.reason.startswith(remedy)
    assert play.reason.endswith("it held because stop is engaged (red button)")


def test_a_marker_that_comes_back_is_gone_on_to() -> None:
    play = MachineRig().reach(State.APPROACHING)
    play.toy.marker, play.faults = None, [TaskFault("marker_missing")]
    play.run(3.0)
    play.toy.marker, play.faults = MARKER, []
    play.to(State.CARRYING)


def test_a_grip_on_the_edge_of_reach_is_not_gone_for_for_ever() -> None:
    play = MachineRig(search_patience=3.0, move_patience=5.0).reach(State.SEARCHING)
    beyond = Pose(MARKER.position + np.array((0.4, 0.0, 0.0)), MARKER.rotation)
    for number in range(round(9.0 / DT)):
        play.toy.marker = beyond if number % 50 < 25 else MARKER
        play.tick()
    assert State.APPROACHING in play.states
    assert play.state is State.HOLDING and "out of reach" in play.reason


def test_a_closed_gripper_without_a_panel_is_no_grasp() -> None:
    play = MachineRig().reach(State.APPROACHING)
    play.toy.parameters = TaskParameters(grasp_position=(0.0, -0.9, 0.0))
    play.run(60.0, lambda: play.state is State.HOLDING)
    assert "the grasp failed" in play.reason and "holds nothing" in play.reason
    assert play.command("reset") is State.IDLE


def test_something_on_the_tool_is_no_zero() -> None:
    play = MachineRig()
    play.changed = {"wrench": [0.0, 4.0, 0.0, 0.0, 0.0, 0.0]}
    play.reach(State.CALIBRATING)
    play.run(5.0)
    assert play.state is State.CALIBRATING and "4.0 N on a free tool, allowed are 3 N" in play.reason


def test_an_arm_that_cannot_give_way_any_further_is_told_with_the_robot_s_reason() -> None:
    play = MachineRig().lifted()
    force = play.settings.half_weight + 1.3 * play.settings.force_limit[2]
    play.changed = {"wrench": np.array((0.0, 0.0, -force, 0.0, 0.0, 0.0)), "robot": "a joint is at its limit"}
    play.run(0.5)
    assert "give way" not in play.reason
    play.run(1.0)
    assert play.reason.endswith("the arm cannot give way any further (a joint is at its limit)")


def test_what_slipped_out_is_no_weight_to_allow_for_while_something_else_is_waited_for() -> None:
    play = MachineRig().lifted()
    play.command("release")
    play.halted("tool")
    assert play.decision.nominal < -5.0
    play.toy.slip()
    play.run(2.0)
    assert play.state is State.RELEASING and play.reason.startswith("waiting: the tool's pose is not known")
    assert play.decision.nominal == 0.0
