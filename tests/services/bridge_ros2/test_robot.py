"""The far side in both dialects: what it hears, what it sends, and what it says of the robot.

Over a real router with a stand-in at its other end, and in a domain of DDS with the real zenoh-bridge-ros2dds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from services.bridge_ros2.codec import decode
from services.bridge_ros2.parameters import BridgeRos2Parameters
from services.bridge_ros2.robot import Ros2Robot
from shared.parameters import Refused
from shared.robot.far_side import TrajectoryPoint
from shared.robot.profile import Profile
from tests.conftest import Router, StartProcess
from tests.services.bridge_ros2 import peer
from tests.services.bridge_ros2.far import FarNetwork
from tests.services.bridge_ros2.far_dds import FarDomain
from tests.support import ros2dds
from tests.support.dds import free_domain
from tests.support.ports import free_endpoint
from tests.support.wait import eventually, throughout

pytestmark = pytest.mark.processes
PROFILE = Profile.load("tiago-ros2")
STOP, CAMERA = PROFILE.emergency_stop, PROFILE.camera
assert STOP is not None and CAMERA is not None
HEADER = peer.Header(peer.Time(1, 2), "")
Far = FarNetwork | FarDomain
Make = Callable[..., Ros2Robot]


@pytest.fixture(params=["ros2dds", "rmw_zenoh", "zenoh-bridge-ros2dds"])
def far(request: pytest.FixtureRequest, start: StartProcess, tmp_path: Path) -> Iterator[Far]:
    if request.param == "zenoh-bridge-ros2dds":
        domain = free_domain()
        _, endpoint = ros2dds.bridge(start, tmp_path, domain)
        with closing(FarDomain(domain, endpoint)) as nodes:
            yield nodes
        return
    router: Router = request.getfixturevalue("shared_router")
    with closing(FarNetwork(router.endpoint, request.param)) as network:
        yield network


@pytest.fixture
def make(far: Far) -> Iterator[Make]:
    made: list[Ros2Robot] = []

    def robot(**options: object) -> Ros2Robot:
        parameters = BridgeRos2Parameters.of({"far": far.endpoint, "dialect": far.dialect, **options})
        made.append(Ros2Robot(PROFILE, parameters))
        return made[-1]

    yield robot
    for each in made:
        each.close()


def joints(*position: float) -> bytes:
    return peer.JointState(HEADER, ["torso_lift_joint"], [*position], [0.0], [0.0]).serialize()


def whole(far: Far) -> None:
    """The robot is as its profile says."""
    for topic, kind in PROFILE.heard().items():
        far.advertise(topic, kind, latched=topic == STOP.topic)
    for topic, kind in PROFILE.commanded().items():
        far.listen(topic, kind)


def test_what_is_said_is_heard(far: Far, make: Make) -> None:
    topic = PROFILE.joints.topic
    far.advertise(topic, "sensor_msgs/msg/JointState")
    robot = make()
    assert robot.joints() is None and robot.wrench() is None and robot.pressed() is None
    eventually(lambda: far.wanted(topic))
    far.publish(topic, joints(0.2))
    heard = eventually(robot.joints)
    assert (heard.message.position.tolist(), heard.number, heard.stamp) == ([0.2], 1, 1_000_000_002)
    assert bool(heard.sender) is (far.dialect == "rmw_zenoh")
    # DDS itself keeps what is no message of a type from leaving.
    far.publish(topic, joints())
    eventually(lambda: robot.joints() and robot.refusals())
    assert robot.refusals()[topic].startswith("1 refused, the last one: position has 0 elements")
    far.publish(topic, joints(0.3))
    eventually(lambda: robot.joints().message.position[0] == 0.3)


def test_commands_arrive_as_the_peer_writes_them(far: Far, make: Make) -> None:
    head, base = PROFILE.controllers["head"].topic, PROFILE.base.topic
    far.listen(head, "trajectory_msgs/msg/JointTrajectory")
    far.listen(base, "geometry_msgs/msg/Twist")
    robot = make()
    points = [TrajectoryPoint(0.5, np.array((0.1, -0.2)), np.zeros(2))]

    def arrived() -> bool:
        robot.move("head", points)
        robot.drive(np.array((0.1, 0.0, 0.2)))
        return bool(far.received[head] and far.received[base])

    eventually(arrived, every=0.05)
    payload, attachment = far.received[head][-1]
    (point,) = decode(payload, "trajectory_msgs/msg/JointTrajectory").points
    assert point.positions.tolist() == [0.1, -0.2]
    twist = peer.Twist(peer.Vector3(0.1, 0.0, 0.0), peer.Vector3(0.0, 0.0, 0.2)).serialize()
    assert far.received[base][-1][0] == twist
    assert (attachment is None) if far.dialect == "ros2dds" else len(attachment or b"") == 33
    robot.move("head", [TrajectoryPoint(0.5, np.array((0.1, np.nan)), np.zeros(2))])
    assert "1 not sent, the last one: position is not finite" in robot.refusals()[head]


def test_a_late_bridge_learns_that_the_emergency_stop_is_pressed(far: Far, make: Make) -> None:
    far.advertise(STOP.topic, STOP.type, latched=True)
    far.publish(STOP.topic, peer.Bool(True).serialize())
    robot = make()
    eventually(robot.emergency)
    far.publish(STOP.topic, peer.Bool(False).serialize())
    eventually(lambda: not robot.emergency())


@pytest.mark.parametrize("pressed", [True, False])
def test_a_bridge_that_was_away_learns_the_last_word_on_the_emergency_stop(far: Far, make: Make, pressed: bool) -> None:
    far.advertise(STOP.topic, STOP.type, latched=True)
    far.publish(STOP.topic, peer.Bool(not pressed).serialize())
    before = make()
    eventually(lambda: bool(before.emergency()) is not pressed and far.wanted(STOP.topic))
    before.close()
    eventually(lambda: not far.wanted(STOP.topic))
    far.publish(STOP.topic, peer.Bool(pressed).serialize())
    robot = make()
    eventually(lambda: bool(robot.emergency()) is pressed and far.wanted(STOP.topic))
    throughout(lambda: bool(robot.emergency()) is pressed, 0.5)


def test_it_is_ready_when_all_is_there(far: Far, make: Make) -> None:
    robot = make()
    eventually(lambda: "no ROS 2 node is to be seen at tcp/" in robot.ready())
    far.listen("/somewhere", "std_msgs/msg/Bool")
    eventually(lambda: "nobody tells whether the emergency stop is pressed" in robot.ready())
    whole(far)
    eventually(lambda: not robot.ready() and not robot.mismatches(), message=lambda: str(robot.mismatches()))
    far.withdraw(PROFILE.wrench.topic)
    eventually(robot.mismatches)
    assert robot.mismatches()[0].startswith(f"nobody publishes {PROFILE.wrench.topic}")
    far.advertise(PROFILE.wrench.topic, "geometry_msgs/msg/Wrench")
    eventually(lambda: "the profile says geometry_msgs/msg/WrenchStamped" in "".join(robot.mismatches()))


def test_pictures_are_subscribed_to_only_while_they_are_wanted(far: Far, make: Make) -> None:
    far.advertise(CAMERA.image, "sensor_msgs/msg/Image")
    far.advertise(PROFILE.joints.topic, "sensor_msgs/msg/JointState")
    robot = make()
    eventually(lambda: far.wanted(PROFILE.joints.topic))
    assert robot.picture(False) is None
    throughout(lambda: not far.wanted(CAMERA.image), 0.3)
    robot.picture(True)
    eventually(lambda: far.wanted(CAMERA.image))
    robot.picture(False)
    eventually(lambda: not far.wanted(CAMERA.image))


def test_who_only_reads_commands_nothing(far: Far, make: Make) -> None:
    whole(far)
    robot = make(read_only=True)
    eventually(lambda: not robot.ready())
    robot.drive(np.zeros(3))
    throughout(lambda: not any(far.received.values()), 0.3)


def test_without_a_network_it_waits_and_comes_back(start: StartProcess) -> None:
    endpoint = free_endpoint()
    robot = Ros2Robot(PROFILE, BridgeRos2Parameters(far=endpoint, dialect="rmw_zenoh"))
    try:
        assert f"nobody answers at {endpoint}" in robot.ready() and len(robot.mismatches()) == 1
        robot.drive(np.zeros(3))
        router = start("services.router", "--listen", endpoint)
        eventually(lambda: "nobody answers" not in robot.ready(), 20.0)
        router.kill()
        eventually(lambda: "nobody answers" in robot.ready())
        start("services.router", "--listen", endpoint)
        eventually(lambda: "nobody answers" not in robot.ready(), 20.0)
    finally:
        robot.close()


def test_what_cannot_work_is_refused() -> None:
    with pytest.raises(Refused, match="far is robot: wanted"):
        Ros2Robot(PROFILE, BridgeRos2Parameters(far="robot"))
    with pytest.raises(Refused, match=r"tiago-ros1 is of ros1: services\.bridge_ros1"):
        Ros2Robot(Profile.load("tiago-ros1"), BridgeRos2Parameters())
