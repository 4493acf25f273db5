"""Ten mistakes that are planted in the simulated ROS robot: each is named in one line before anything moves."""

from __future__ import annotations

import pytest

from services.ros_robot.parameters import MISTAKES
from shared.messages import BaseTwistCommand
from shared.topics import COMMAND_BASE_TWIST
from tests.support.ros_far_side import RosRig

NAMED = {
    "sign": "/wrist_right_ft: by the tool's weight, it has the opposite sign",
    "turned": "/wrist_right_ft: by the tool's weight, its axes are turned by 45 degrees about z",
    "joint_order": "/joint_states: the order of joints changes from message to message",
    "tool_frame": "/wrist_right_ft is in the frame arm_right_tool_link, the profile says wrist_right_ft_link",
    "emergency": "the robot's emergency stop is pressed",
    "not_switchable": "arm_right_controller does not run",
    "bgr8": "/xtion/rgb/image_raw comes in bgr8, the profile says rgb8",
    "two_publishers": "/joint_states has two publishers, robot and joint_state_publisher",
    "clock": "the robot's clock is 60 min ahead of this machine's",
}


def test_there_is_a_test_for_every_mistake() -> None:
    assert {*NAMED, "mux_locked"} == set(MISTAKES)


@pytest.mark.parametrize("mistake", NAMED)
def test_a_mistake_is_named_before_anything_moves(mistake: str) -> None:
    scene = {"scene": "full"} if mistake == "bgr8" else {}
    rig = RosRig(robot={"mistakes": (mistake,)} | scene)
    rig.stack.run(1.5)
    words = f"{rig.status.reason}; {rig.bridge.notes()}"
    assert NAMED[mistake] in words
    assert "\n" not in words
    assert rig.status.mode == "stopped"
    assert rig.far.moved == 0


def test_a_base_whose_commands_go_nowhere_is_named() -> None:
    rig = RosRig(robot={"mistakes": ("mux_locked",)})
    rig.release()
    for _ in range(75):
        rig.stack.client.publish(COMMAND_BASE_TWIST, BaseTwistCommand((0.1, 0.0, 0.0), 0.1))
        rig.stack.run(0.02)
    assert "the base does not move as /servoing_cmd_vel tells it to: a lock of twist_mux" in rig.status.reason


@pytest.mark.parametrize("profile", ["tiago-ros1", "tiago-ros2"])
def test_nothing_is_named_of_a_robot_that_is_as_its_profile_says(profile: str) -> None:
    rig = RosRig(profile, robot={"ft_bias": [1.0, -1.0, 1.0, 0.05, 0.05, 0.05]})
    rig.stack.run(4.0)
    assert rig.bridge.notes() == ""
    assert rig.status.reason == "stop engaged: the bridge has just started. Release it with `tandem resume`"
