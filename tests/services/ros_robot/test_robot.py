"""The whole robot as an adapter meets it: topics in, topics out, and what is wrong with it on purpose."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from services.ros_robot.messages import Flag, Point, Publication, Trajectory, Twist, Velocities
from services.ros_robot.parameters import RosRobotParameters
from services.ros_robot.robot import PRESS, RosRobot
from services.ros_robot.sensors import EXTRA_JOINTS, HOUR, LEFT_OVER, TOOL_LINK
from services.sim.robot.kinematics import HOME
from shared.parameters import Refused
from shared.robot.far_side import Calibration, Joints, Picture
from shared.robot.profile import Profile
from shared.sim_messages import Load, Reset, SensorFault

PROFILES = {which: Profile.load(f"tiago-{which}") for which in ("ros1", "ros2")}
ARM = PROFILES["ros1"].controllers["arm"]
QUIET = {"ft_noise": [0.0] * 6, "ft_drift": [0.0] * 6}


class Rig:
    """A robot, and the last message of each topic and node."""

    def __init__(self, which: str = "ros1", scene: str = "load", **parameters: Any) -> None:
        self.profile = PROFILES[which]
        given = RosRobotParameters.of({"scene": scene, **QUIET, **parameters})
        self.robot = RosRobot(self.profile, given)
        self.all: list[Publication] = []
        self.watched = False

    def run(self, duration: float) -> list[Publication]:
        new = [one for _ in range(round(duration * self.robot.rate)) for one in self.robot.tick(self.watched)]
        self.all += new
        return new

    def last(self, topic: str, node: str = "robot") -> Publication:
        return next(one for one in reversed(self.all) if one.topic == topic and one.node == node)

    def joints(self) -> dict[str, float]:
        content = self.last(self.profile.joints.topic).content
        assert isinstance(content, Joints)
        return dict(zip(content.names, content.position.tolist(), strict=True))

    def force(self) -> np.ndarray:
        return self.last(self.profile.wrench.topic).content.force  # type: ignore[union-attr]

    def arm(self) -> np.ndarray:
        return np.array([self.joints()[joint] for joint in ARM.joints])

    def at_home(self) -> np.ndarray:
        return np.array([HOME[joint] for joint in ARM.joints])


@pytest.mark.parametrize("which", PROFILES)
def test_every_topic_has_its_rate(which: str) -> None:
    rig = Rig(which, scene="full")
    rig.watched = True
    told = rig.run(1.0)
    profile = rig.profile
    assert profile.base is not None and profile.camera is not None and profile.emergency_stop is not None
    rates = {
        profile.joints.topic: 50,
        profile.wrench.topic: 100,
        profile.base.odometry: 50,
        profile.camera.image: 10,
        profile.camera.info: 10,
        profile.emergency_stop.topic: 1,
    }
    counted = {topic: sum(one.topic == topic for one in told) for topic in rates}
    assert counted == pytest.approx(rates, abs=2)
    assert {one.topic: one.kind for one in told} == rig.robot.publications
    assert rig.last(profile.emergency_stop.topic).latched


def test_nobody_watches_and_no_picture_is_made() -> None:
    rig = Rig(scene="full")
    assert PROFILES["ros1"].camera is not None
    assert PROFILES["ros1"].camera.image not in {one.topic for one in rig.run(0.5)}


def test_ros2_reports_joints_that_mean_nothing() -> None:
    old, new = Rig("ros1"), Rig("ros2")
    for rig in (old, new):
        rig.run(0.1)
    assert set(new.joints()) - set(old.joints()) == set(EXTRA_JOINTS) and len(EXTRA_JOINTS) == 10


def test_the_arm_reaches_where_it_is_sent_and_follows_on_the_way() -> None:
    rig = Rig()
    rig.run(0.1)
    start = rig.arm()
    assert start == pytest.approx(rig.at_home(), abs=1e-3)
    goal = start + np.array((-0.3, 0.1, 0.1, -0.2, 0.2, -0.2, 0.3))
    assert rig.robot.command(ARM.topic, Trajectory(ARM.joints[::-1], (Point(1.0, goal[::-1], np.zeros(7)),))) == ""
    rig.run(0.5)
    assert rig.arm() == pytest.approx(0.5 * (start + goal), abs=0.02)
    rig.run(0.7)
    assert rig.arm() == pytest.approx(goal, abs=1e-3)


def test_a_step_moves_the_arm_no_faster_than_its_motors_allow() -> None:
    rig = Rig("ros2")
    rig.run(0.1)
    goal = rig.arm() - 0.5
    rig.robot.command(rig.profile.controllers["arm"].topic, Trajectory(ARM.joints, (Point(0.0, goal),)))
    rig.run(0.05)
    assert 0.02 < np.abs(rig.arm() - rig.at_home()).max() < 0.3
    rig.run(2.0)
    assert rig.arm() == pytest.approx(goal, abs=0.01)


def test_a_velocity_command_moves_the_arm_until_the_controller_is_stopped() -> None:
    rig = Rig()
    group = "arm_right_forward_velocity_controller"
    assert rig.robot.switch([group], [ARM.controller])
    rig.robot.command(f"/{group}/command", Velocities(np.array((-0.1, 0, 0, 0, 0, 0, 0))))
    rig.run(1.5)
    assert rig.arm()[0] == pytest.approx(rig.at_home()[0] - 0.15, abs=0.01)
    rig.robot.switch([ARM.controller], [group])
    rig.run(0.2)
    before = rig.arm()
    rig.run(0.5)
    assert rig.arm() == pytest.approx(before, abs=1e-3)


def test_torso_head_and_fingers_go_where_they_are_sent() -> None:
    rig = Rig()
    goals = {"torso": (0.3,), "head": (0.2, -0.1), "gripper": (0.03, 0.03)}
    for name, goal in goals.items():
        row = rig.profile.controllers[name]
        assert rig.robot.command(row.topic, Trajectory(row.joints, (Point(1.0, np.array(goal)),))) == ""
    rig.run(1.5)
    for name, goal in goals.items():
        assert [rig.joints()[joint] for joint in rig.profile.controllers[name].joints] == pytest.approx(goal, abs=2e-3)


def test_the_base_moves_through_twist_mux_and_halts() -> None:
    rig = Rig()
    assert rig.profile.base is not None
    for _ in range(10):
        rig.robot.command(rig.profile.base.topic, Twist(np.array((0.1, 0.0, 0.0))))
        rig.run(0.1)
    rig.run(1.0)
    odometry: Any = rig.last(rig.profile.base.odometry).content
    assert odometry.position[0] == pytest.approx(0.125, abs=0.02)
    assert not odometry.velocity.any()


def test_who_has_less_priority_is_refused_and_told() -> None:
    rig = Rig()
    rig.robot.command("/joy_vel", Twist(np.zeros(3)))
    assert "another source" in rig.robot.command("/nav_vel", Twist(np.ones(3)))
    assert rig.robot.refusals()["/nav_vel"] == (1, "twist_mux: another source has priority")


def test_a_kilogram_pulls_down_in_the_profiles_axes() -> None:
    rig = Rig()
    rig.run(0.2)
    before = rig.force()
    rig.robot.carry_out(Load(mass=1.0))
    rig.run(2.0)
    # In this posture the tool's axes are the base's; the tool's x is the sensor's z, its z the sensor's y.
    pulled = rig.force() - before
    assert np.linalg.norm(pulled) == pytest.approx(9.81, abs=0.3)
    assert rig.robot.world().bag is not None


def test_the_emergency_stop_halts_everything_and_nothing_resumes() -> None:
    rig = Rig()
    assert rig.profile.emergency_stop is not None
    rig.robot.command(ARM.topic, Trajectory(ARM.joints, (Point(2.0, rig.at_home() - 0.5),)))
    rig.run(0.5)
    rig.robot.command(PRESS, Flag(True))
    rig.run(0.2)
    where = rig.arm()
    assert rig.last(rig.profile.emergency_stop.topic).content == Flag(True)
    assert "emergency" in rig.robot.command(ARM.topic, Trajectory(ARM.joints, (Point(1.0, rig.at_home()),)))
    assert "emergency" in rig.robot.command("/nav_vel", Twist(np.ones(3)))
    rig.robot.command(PRESS, Flag(False))
    rig.run(1.0)
    assert rig.arm() == pytest.approx(where, abs=2e-3)
    assert rig.last(rig.profile.emergency_stop.topic).content == Flag(False)


def test_a_reset_puts_the_arm_back_and_keeps_it_there() -> None:
    rig = Rig()
    rig.robot.command(ARM.topic, Trajectory(ARM.joints, (Point(0.5, rig.at_home() - 0.3),)))
    rig.run(1.0)
    rig.robot.carry_out(Reset())
    rig.run(1.0)
    assert rig.arm() == pytest.approx(rig.at_home(), abs=1e-3)


def test_a_sensor_can_be_broken() -> None:
    rig = Rig()
    rig.run(0.1)
    rig.robot.carry_out(SensorFault(target="ft", kind="off", value=0.0))
    assert rig.profile.wrench.topic not in {one.topic for one in rig.run(0.2)}
    rig.robot.carry_out(SensorFault(target="joints", kind="garbage", value=0.0))
    rig.run(0.1)
    assert np.isnan(rig.arm()).all()


def test_a_robot_that_is_no_tiago_is_refused() -> None:
    with pytest.raises(Refused, match="ur5e"):
        RosRobot(Profile.load("ur5e-ros2"), RosRobotParameters())


# The planted mistakes, against a robot without any.


def pair(mistake: str, scene: str = "load") -> tuple[Rig, Rig]:
    rigs = Rig(scene=scene), Rig(scene=scene, mistakes=[mistake])
    for rig in rigs:
        rig.watched = True
        rig.run(0.3)
    return rigs


def test_sign() -> None:
    right, wrong = pair("sign")
    assert wrong.force() == pytest.approx(-right.force(), abs=1e-3)


def test_turned() -> None:
    right, wrong = pair("turned")
    assert wrong.force()[2] == pytest.approx(right.force()[2], abs=1e-3)
    assert np.linalg.norm(wrong.force()) == pytest.approx(np.linalg.norm(right.force()), abs=1e-3)
    cosine = (
        right.force()[:2] @ wrong.force()[:2] / np.prod([np.linalg.norm(rig.force()[:2]) for rig in (right, wrong)])
    )
    assert np.degrees(np.arccos(cosine)) == pytest.approx(45.0, abs=1.0)


def test_joint_order() -> None:
    _, wrong = pair("joint_order")
    orders = {one.content.names for one in wrong.all if isinstance(one.content, Joints)}
    assert len(orders) == 2
    assert wrong.arm() == pytest.approx(wrong.at_home(), abs=1e-3)


def test_tool_frame() -> None:
    right, wrong = pair("tool_frame")
    assert wrong.last(wrong.profile.wrench.topic).frame == TOOL_LINK
    # The sensor's z is the tool link's x.
    assert wrong.force()[0] == pytest.approx(right.force()[2], abs=1e-3)


def test_emergency() -> None:
    _, wrong = pair("emergency")
    assert wrong.profile.emergency_stop is not None
    assert wrong.last(wrong.profile.emergency_stop.topic).content == Flag(True)
    assert set(row.state for row in wrong.robot.listed()) == {"stopped"}


def test_not_switchable() -> None:
    _, wrong = pair("not_switchable")
    assert "not running" in wrong.robot.command(ARM.topic, Trajectory(ARM.joints, (Point(1.0, np.zeros(7)),)))
    assert not wrong.robot.switch([ARM.controller], [])


def test_bgr8() -> None:
    right, wrong = pair("bgr8", scene="full")
    assert right.profile.camera is not None
    pictures, calibrations = (
        [rig.last(topic).content for rig in (right, wrong)]
        for topic in (right.profile.camera.image, right.profile.camera.info)
    )
    assert [picture.encoding for picture in pictures if isinstance(picture, Picture)] == ["rgb8", "bgr8"]
    assert [len(one.distortion) for one in calibrations if isinstance(one, Calibration)] == [5, 8]
    red, blue = (np.frombuffer(picture.data, np.uint8).reshape(480, 640, 3).mean((0, 1)) for picture in pictures)  # type: ignore[union-attr]
    assert red == pytest.approx(blue[::-1], abs=1.0)


def test_two_publishers() -> None:
    _, wrong = pair("two_publishers")
    assert not wrong.last(wrong.profile.joints.topic, LEFT_OVER).content.position.any()  # type: ignore[union-attr]


def test_clock() -> None:
    right, wrong = pair("clock")
    topic = right.profile.joints.topic
    assert wrong.last(topic).stamp - right.last(topic).stamp == HOUR


def test_mux_locked() -> None:
    _, wrong = pair("mux_locked")
    assert wrong.profile.base is not None
    assert "/pause_navigation" in wrong.robot.command(wrong.profile.base.topic, Twist(np.ones(3)))


def test_a_mistake_that_is_none_is_refused() -> None:
    with pytest.raises(Refused, match="mistakes"):
        RosRobotParameters.of({"mistakes": ["spelling"]})
    with pytest.raises(Refused, match="twice"):
        RosRobotParameters.of({"mistakes": ["sign", "sign"]})
