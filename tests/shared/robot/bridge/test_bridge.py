"""A bridge and an ideal robot: it moves as it is told while a person lets it, and tells what the robot says."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from services.controller.controller import Controller
from services.controller.parameters import ControllerParameters
from services.wrench.parameters import WrenchParameters
from services.wrench.wrench import Wrench
from shared.messages import (
    BaseTwistCommand,
    ControlTarget,
    EnableDevice,
    GripperCommand,
    HeadCommand,
)
from shared.parameters import Refused
from shared.robot.bridge.base import FADING
from shared.robot.far_side import Calibration, Heard, Picture
from shared.spatial import quaternion
from shared.topics import (
    COMMAND_BASE_TWIST,
    COMMAND_GRIPPER,
    COMMAND_HEAD,
    CONTROL_TARGET,
    OPERATOR_ENABLE,
    SENSOR_CAMERA,
    SENSOR_FT,
    STATE_BASE,
    STATE_EE,
    STATE_GRIPPER,
    STATE_JOINTS,
)
from tests.shared.robot.bridge.far import WALL, BridgeRig

PROFILES = ("tiago-ros1", "tiago-ros2", "ur5e-ros2")
FINGERS = ("gripper_right_left_finger_joint", "gripper_right_right_finger_joint")


@pytest.mark.parametrize("profile", PROFILES)
def test_the_tool_goes_where_it_is_told(profile: str) -> None:
    rig = BridgeRig(profile)
    rig.release()
    before = rig.robot.tool
    rig.drive((0.05, 0.0, -0.1), 1.0)
    rig.stack.run(0.3)
    # What the start takes longer, up to a twentieth of a second, the end does too.
    assert rig.robot.tool - before == pytest.approx((0.05, 0.0, -0.1), abs=0.006)
    assert rig.robot.arm_speed == 0.0


@pytest.mark.parametrize("profile", PROFILES)
def test_what_the_robot_says_is_told_in_the_words_of_the_contract(profile: str) -> None:
    rig = BridgeRig(profile)
    heard = {topic: rig.stack.client.watch(topic) for topic in (SENSOR_FT, STATE_EE, STATE_JOINTS, STATE_BASE)}
    rig.stack.run(1.0)
    latest = {topic: heard[topic].latest for topic in heard}
    assert all(received is not None and received.header.valid for received in latest.values())
    sample, pose = latest[SENSOR_FT].message, latest[STATE_EE].message
    assert pose.position == pytest.approx(rig.robot.tool)
    assert np.linalg.norm(sample.force) == pytest.approx(rig.robot.weight)
    assert np.linalg.norm(sample.tool_offset) > 0.1
    rates = rig.robot.profile.joints.rate, min(rig.robot.profile.wrench.rate, 200.0)
    assert heard[STATE_JOINTS].accepted == pytest.approx(min(rates[0], 200.0), abs=2)
    assert heard[SENSOR_FT].accepted == pytest.approx(rates[1], abs=2)


def test_a_tenth_of_all_limits_is_a_tenth_of_the_speed() -> None:
    rig = BridgeRig(scale=0.1)
    rig.release()
    before = rig.robot.tool
    rig.drive((0.0, 0.0, -0.3), 1.0)
    rig.stack.run(0.3)
    assert (rig.robot.tool - before)[2] == pytest.approx(-0.03, abs=0.002)
    assert rig.status.max_linear == pytest.approx(0.03)
    assert rig.status.max_base[0] == pytest.approx(0.1)


def test_a_bridge_that_only_reads_commands_nothing_whoever_releases_it() -> None:
    rig = BridgeRig(read_only=True)
    samples = rig.stack.client.watch(SENSOR_FT)
    rig.release()
    rig.drive((0.0, 0.0, -0.1), 0.5)
    rig.stack.client.publish(COMMAND_GRIPPER, GripperCommand(0.0, 10.0))
    rig.stack.run(0.5)
    assert "read-only" in rig.status.reason and rig.status.mode == "stopped"
    assert rig.robot.moves == [] and rig.robot.drives == []
    assert samples.accepted > 50


def test_without_the_enabling_device_nothing_moves_and_letting_go_brakes() -> None:
    rig = BridgeRig(require_enable=True)
    rig.release()
    rig.drive((0.0, 0.0, -0.1), 0.3)
    assert rig.robot.moves == []
    rig.drive((0.0, 0.0, -0.1), 0.5, lambda: rig.stack.client.publish(OPERATOR_ENABLE, EnableDevice(True)))
    assert rig.robot.arm_speed > 0.0
    rig.drive((0.0, 0.0, -0.1), 0.3, lambda: rig.stack.client.publish(OPERATOR_ENABLE, EnableDevice(False)))
    assert rig.robot.arm_speed == 0.0


def test_the_robots_own_enabling_device_counts_while_it_speaks() -> None:
    rig = BridgeRig(require_enable=True)
    rig.release()
    rig.drive((0.0, 0.0, -0.1), 0.5, lambda: rig.robot.publish("pressed", True, "/joy"))
    assert rig.robot.arm_speed > 0.0
    rig.drive((0.0, 0.0, -0.1), 0.6)
    assert rig.robot.arm_speed == 0.0


def test_the_base_is_driven_and_left_to_others_when_it_rests() -> None:
    rig = BridgeRig()
    rig.release()
    for _ in range(25):
        rig.stack.client.publish(COMMAND_BASE_TWIST, BaseTwistCommand((0.2, 0.0, 0.0), 0.1))
        rig.stack.run(0.02)
    assert rig.robot.driven == pytest.approx((0.2, 0.0, 0.0))
    rig.stack.run(0.5 + FADING)
    assert not rig.robot.driven.any()
    sent = len(rig.robot.drives)
    rig.stack.run(0.5)
    assert len(rig.robot.drives) == sent


def test_an_arm_on_a_fixed_base_has_a_base_that_cannot_move() -> None:
    rig = BridgeRig("ur5e-ros2")
    base, gripper = rig.stack.client.watch(STATE_BASE), rig.stack.client.watch(STATE_GRIPPER)
    rig.release()
    rig.stack.client.publish(COMMAND_BASE_TWIST, BaseTwistCommand((0.2, 0.0, 0.0), 0.1))
    rig.stack.run(0.1)
    assert base.latest is not None and not base.latest.message.velocity.any()
    assert not rig.status.max_base.any()
    assert gripper.latest is None
    assert rig.robot.drives == []


def test_the_head_turns_at_its_speed() -> None:
    rig = BridgeRig()
    rig.release()
    rig.stack.client.publish(COMMAND_HEAD, HeadCommand(0.9, -0.3))
    rig.stack.run(1.0)
    assert [rig.robot.position[joint] for joint in ("head_1_joint", "head_2_joint")] == pytest.approx([0.9, -0.3])


def test_the_fingers_open_and_tell_their_opening() -> None:
    rig = BridgeRig()
    told = rig.stack.client.watch(STATE_GRIPPER)
    rig.release()
    rig.stack.client.publish(COMMAND_GRIPPER, GripperCommand(0.08, 10.0))
    rig.stack.run(2.5)
    assert told.latest is not None
    assert told.latest.message.opening == pytest.approx(0.08)
    assert not told.latest.message.holding


def test_fingers_that_are_kept_from_closing_hold_what_is_between_them_through_a_stop() -> None:
    rig = BridgeRig()
    told = rig.stack.client.watch(STATE_GRIPPER)
    rig.robot.between = 0.05
    rig.release()
    rig.stack.client.publish(COMMAND_GRIPPER, GripperCommand(0.08, 10.0))
    rig.stack.run(2.5)
    rig.stack.client.publish(COMMAND_GRIPPER, GripperCommand(0.0, 10.0))
    rig.stack.run(3.0)
    assert told.latest is not None
    assert told.latest.message.holding and told.latest.message.opening == pytest.approx(0.05)
    rig.stop()
    rig.stack.run(0.5)
    squeezed = sum(rig.robot.controllers["gripper"].sample(rig.stack.now)[0])
    assert 0.03 < squeezed < 0.047
    rig.robot.between = 0.0
    rig.stack.run(0.5)
    assert not told.latest.message.holding


def test_images_pass_while_somebody_wants_them_and_one_is_looked_at_before() -> None:
    rig = BridgeRig()
    rig.robot.shot = (
        Heard(Picture(4, 2, "rgb8", bytes(24)), 1, 0, 0, "/camera"),
        Heard(Calibration(4, 2, np.array((5.0, 5.0, 2.0, 1.0)), np.zeros(5), "plumb_bob"), 1, 0, 0, "/camera"),
    )
    rig.stack.run(0.1)
    assert rig.robot.wanted[0] and not rig.robot.wanted[-1]
    images = rig.stack.client.watch(SENSOR_CAMERA)
    for number in range(2, 32):
        rig.robot.shot = tuple(Heard(part.message, number, 0, 0, "") for part in rig.robot.shot)
        rig.stack.run(1 / 30)
    assert rig.robot.wanted[-1]
    assert images.accepted == pytest.approx(10, abs=1)
    assert images.latest is not None and images.latest.message.position[2] > 1.0


def test_an_image_is_told_with_the_pose_that_the_camera_had_when_it_was_taken() -> None:
    rig = BridgeRig()
    images = rig.stack.client.watch(SENSOR_CAMERA)
    rig.release()
    before = Heard(Picture(4, 2, "rgb8", bytes(24)), 1, 0, WALL + round(rig.stack.now * 1e9), "/camera")
    lens = Heard(Calibration(4, 2, np.array((5.0, 5.0, 2.0, 1.0)), np.zeros(5), "plumb_bob"), 1, 0, None, "/camera")
    rig.stack.client.publish(COMMAND_HEAD, HeadCommand(1.0, 0.0))
    rig.stack.run(0.5)
    assert rig.robot.position["head_1_joint"] > 0.5
    now = rig.stack.scheduler.clock.now_ns()
    rig.robot.shot = replace(before, arrival=now), lens
    rig.stack.run(0.05)
    assert images.latest is not None
    still = rig.bridge._watch.state._camera
    assert still is not None
    place, rotation = still.at(rig.robot.position | {"head_1_joint": 0.0, "head_2_joint": 0.0})
    assert images.latest.message.position == pytest.approx(place, abs=1e-6)
    assert images.latest.message.orientation == pytest.approx(quaternion(rotation), abs=1e-6)
    assert images.latest.header.stamp < now - 4 * 10**8


def test_a_profile_that_is_none_is_refused() -> None:
    with pytest.raises(Refused, match="there are tiago-ros1"):
        BridgeRig("tiago")


def test_the_chain_lets_the_tool_yield_to_a_push(tmp_path: Path) -> None:
    rig = BridgeRig("tiago-ros1")
    rig.stack.add(Wrench(WrenchParameters(), tmp_path))
    rig.stack.add(Controller(ControllerParameters()))
    rig.release()
    start = rig.robot.tool
    target = ControlTarget(start, (0.0, 0.0, 0.0, 1.0), (25.0,) * 3, (10.0,) * 3)

    def go_on(duration: float) -> None:
        for _ in range(round(duration / 0.2)):
            rig.stack.client.publish(CONTROL_TARGET, target)
            rig.stack.run(0.2)

    go_on(1.0)
    rig.tare()
    go_on(2.0)
    resting = rig.robot.tool
    rig.robot.applied = np.array((0.0, 40.0, 0.0))
    go_on(1.0)
    away = rig.robot.tool - resting
    assert away[1] > 0.02
    assert away[1] > 5.0 * abs(away[0]) and away[1] > 5.0 * abs(away[2])
