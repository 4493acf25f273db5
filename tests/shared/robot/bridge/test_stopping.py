"""Whatever happens to bridge or robot: the arm comes to rest in time, and nothing goes on that nobody has released."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
import pytest

from shared.messages import BaseTwistCommand, GripperCommand, HeadCommand, Stop
from shared.robot.bridge.bridge import RELEASES_KEPT, STALLED
from shared.robot.bridge.motion import REST_WITHIN, SLACK
from shared.robot.bridge.state import SILENT_AFTER
from shared.topics import COMMAND_BASE_TWIST, COMMAND_GRIPPER, COMMAND_HEAD, STOP
from tests.shared.robot.bridge.far import BridgeRig

DOWN = (0.0, 0.0, -0.2)
JITTER = 0.01  # [s]


def moving(profile: str = "tiago-ros1") -> BridgeRig:
    """A bridge whose arm goes down at 0.2 m/s."""
    rig = BridgeRig(profile)
    rig.release()
    rig.drive(DOWN, 0.5)
    assert rig.robot.arm_speed > 0.0
    return rig


def rests(rig: BridgeRig, within: float, beside: Callable[[], None] = lambda: None) -> bool:
    """Let time pass, with commands that go on; whether the arm rests by then and ever after."""
    rig.drive(DOWN, within, beside)
    place = rig.robot.arm
    rig.drive(DOWN, 0.5, beside)
    return rig.robot.arm_speed == 0.0 and bool((rig.robot.arm == place).all())


@pytest.mark.parametrize("profile", ["tiago-ros1", "tiago-ros2", "ur5e-ros2"])
def test_a_bridge_that_is_killed_leaves_an_arm_that_comes_to_rest(profile: str) -> None:
    rig = moving(profile)
    rig.stack.kill(rig.runner)
    assert rests(rig, REST_WITHIN + JITTER)
    assert REST_WITHIN + JITTER < 0.25


def test_commands_that_end_bring_the_arm_to_rest_sooner() -> None:
    rig = moving()
    rig.stack.run(0.05 + 0.15)
    assert rig.robot.arm_speed == 0.0


@pytest.mark.parametrize(
    ("happens", "words"),
    [
        (lambda rig: setattr(rig.robot, "pressed_by", "/power_board"), "emergency stop is pressed, says /power_board"),
        (lambda rig: setattr(rig.robot, "unready", "arm_right_controller does not run"), "controller does not run"),
        (lambda rig: rig.robot.published.discard("joints"), "no joint states on /joint_states"),
        (lambda rig: rig.robot.tell_all_but("arm_right_4_joint"), "/joint_states does not tell arm_right_4_joint"),
    ],
    ids=("emergency stop", "controller", "joints silent", "joint absent"),
)
def test_what_takes_the_robot_away_engages_a_stop_that_stays(
    happens: Callable[[BridgeRig], object], words: str
) -> None:
    rig = moving()
    happens(rig)
    assert rests(rig, SILENT_AFTER + 0.2)
    assert rig.status.mode == "stopped" and words in rig.status.reason
    rig.stack.client.publish(STOP, Stop(False, ""))
    assert rests(rig, 0.1)
    assert rig.status.mode == "stopped"
    rig.robot.heal()
    assert rests(rig, 0.5)
    assert rig.status.mode == "stopped"
    rig.release()
    rig.drive(DOWN, 0.5)
    assert rig.status.mode == "ready" and rig.robot.arm_speed > 0.0


@pytest.mark.parametrize("profile", ["tiago-ros1", "tiago-ros2", "ur5e-ros2"])
def test_what_is_kept_on_the_way_and_arrives_late_does_not_lead_an_arm_on_that_rests(profile: str) -> None:
    rig = moving(profile)
    before, speeds = rig.robot.arm_speed, []
    rig.robot.cut()
    assert rests(rig, REST_WITHIN + JITTER)
    assert rig.status.mode == "stopped"
    place = rig.robot.tool
    rig.robot.mend()
    rig.drive(DOWN, 0.5, lambda: speeds.append(rig.robot.arm_speed))
    assert rig.status.mode == "stopped" and rig.robot.arm_speed == 0.0
    # That between two trajectories and two joint states; 42 mm where the bridge goes on for a quarter of a second.
    assert np.linalg.norm(rig.robot.tool - place) < 0.005 and max(speeds) < 0.6 * before


def test_a_bridge_that_hung_does_not_go_on_by_itself() -> None:
    rig = moving()
    place = rig.robot.tool
    rig.hang(STALLED + 0.1)
    rig.drive(DOWN, 0.5)
    assert rig.status.mode == "stopped" and "the bridge stood still for 0." in rig.status.reason
    assert rig.robot.arm_speed == 0.0
    assert place[2] - rig.robot.tool[2] < 0.2 * REST_WITHIN


def test_a_release_that_was_on_its_way_while_the_bridge_hung_is_none() -> None:
    rig = moving()
    rig.hang(STALLED + 0.1)
    rig.drive(DOWN, RELEASES_KEPT - 0.2)
    rig.release()  # within 0.2 s
    rig.drive(DOWN, 0.5)
    assert rig.status.mode == "stopped" and "the bridge stood still for 0." in rig.status.reason
    rig.release()
    rig.drive(DOWN, 0.5)
    assert rig.status.mode == "ready" and rig.robot.arm_speed > 0.0


def test_what_a_step_meant_before_it_hung_is_not_told_after_it(monkeypatch: pytest.MonkeyPatch) -> None:
    rig = moving()
    clock, hung, told = vars(rig.bridge)["_clock"], [0], []

    def hang() -> str:
        hung[0] = 1_000_000_000
        return ""

    monkeypatch.setattr(rig.robot, "ready", hang)  # asked in the midst of each step
    monkeypatch.setattr(rig.robot, "move", lambda controller, points: told.append(points))
    monkeypatch.setattr(rig.bridge, "_clock", SimpleNamespace(now_ns=lambda: clock.now_ns() + hung[0]))
    rig.drive(DOWN, 0.1)
    assert rig.status.mode == "stopped" and not told


def test_a_short_stall_is_made_up_for_without_a_jump() -> None:
    rig = moving()
    speeds = rig.robot.log_speeds()
    rig.hang(0.1)
    rig.drive(DOWN, 0.5)
    assert rig.status.mode == "ready" and rig.robot.arm_speed > 0.0
    changes = [abs(after - before) for before, after in itertools.pairwise(speeds)]
    assert max(changes) < 10.0 * 0.002 * 1.01


def test_a_stop_freezes_head_and_fingers_too_and_they_stay_after_its_release() -> None:
    rig = BridgeRig()
    rig.release()
    rig.stack.client.publish(COMMAND_HEAD, HeadCommand(1.2, 0.0))
    rig.stack.client.publish(COMMAND_GRIPPER, GripperCommand(0.09, 10.0))
    rig.stack.run(0.3)
    rig.stop()
    rig.stack.run(0.3)
    names = ("head_1_joint", "gripper_right_left_finger_joint")
    places = [rig.robot.position[name] for name in names]
    assert 0.05 < places[0] < 1.1 and 0.001 < places[1] < 0.04
    rig.release()
    rig.stack.run(2.0)
    assert [rig.robot.position[name] for name in names] == places


def test_a_stop_brakes_the_base() -> None:
    rig = BridgeRig()
    rig.release()
    for number in range(100):
        rig.stack.client.publish(COMMAND_BASE_TWIST, BaseTwistCommand((0.2, 0.0, 0.0), 0.1))
        rig.stack.run(0.02)
        if number == 50:
            assert rig.robot.driven[0] == pytest.approx(0.2)
            rig.robot.pressed_by = "/power_board"
    assert not rig.robot.driven.any()


def test_after_a_stop_the_arm_goes_on_from_where_somebody_has_led_it() -> None:
    rig = moving()
    rig.stop()
    rig.stack.run(0.5)
    led = rig.robot.arm + 0.2 * (rig.robot.arm < 1.0)
    rig.robot.lead(led)
    rig.stack.run(0.2)
    rig.release()
    rig.drive((0.0, 0.0, 0.001), 0.2)
    assert rig.robot.arm == pytest.approx(led, abs=0.01)


def test_an_arm_that_rests_and_is_led_elsewhere_is_not_pulled_back() -> None:
    rig = moving()
    rig.stack.run(1.0)
    led = rig.robot.arm + 0.2 * (rig.robot.arm < 1.0)
    rig.robot.lead(led)
    rig.stack.run(1.0)
    rig.drive((0.0, 0.0, 0.001), 0.2)
    assert rig.robot.arm == pytest.approx(led, abs=0.01)


def test_a_load_that_bends_the_arm_does_not_make_it_sink_from_motion_to_motion() -> None:
    rig = BridgeRig()
    rig.release()
    rig.robot.sag = 0.5 * SLACK
    before = rig.robot.arm
    for _ in range(20):
        rig.drive((0.0, 0.0, 0.01), 0.1)
        rig.drive((0.0, 0.0, -0.01), 0.1)
        rig.stack.run(1.0)
    assert rig.robot.arm == pytest.approx(before, abs=0.2 * SLACK)


def test_the_bridge_hands_the_robot_back_when_it_ends() -> None:
    rig = moving()
    rig.runner.close()
    rig.stack.kill(rig.runner)
    rig.stack.run(0.2)
    assert rig.robot.arm_speed == 0.0
    rig.bridge.close()
    assert rig.robot.closed
