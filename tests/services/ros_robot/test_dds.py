"""The robot in a domain of DDS, as somebody else there meets it: names, types and qualities of service of ROS 2."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing

import numpy as np
import pytest
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Qos
from cyclonedds.sub import DataReader

from services.ros_robot.dds import LATCHED, LOOPBACK, RELIABLE, SENSOR, DdsAdapter, connect
from services.ros_robot.dds_types import GRAPH, Encoded, topic
from services.ros_robot.messages import Command, Flag, Publication, Twist
from services.ros_robot.parameters import RosRobotParameters
from services.ros_robot.robot import RosRobot
from shared.parameters import Refused
from shared.robot.profile import Profile
from tests.services.bridge_ros2 import peer
from tests.support.dds import free_domain
from tests.support.wait import eventually

pytestmark = pytest.mark.processes
PROFILE = Profile.load("tiago-ros2")
STOP, CAMERA, BASE = PROFILE.emergency_stop, PROFILE.camera, PROFILE.base
assert STOP is not None and CAMERA is not None and BASE is not None


class Commanded(RosRobot):
    """Keeps what it is commanded."""

    def command(self, topic: str, message: Command) -> str:
        self.commanded[topic] = message
        return ""


@pytest.fixture
def robot() -> Commanded:
    robot = Commanded(PROFILE, RosRobotParameters.of({"profile": "tiago-ros2", "scene": "load"}))
    robot.commanded = {}
    return robot


@pytest.fixture
def domain() -> int:
    return free_domain()


@pytest.fixture
def adapter(robot: RosRobot, domain: int) -> Iterator[DdsAdapter]:
    with closing(connect(robot, str(domain))) as adapter:
        yield adapter


@pytest.fixture
def other(adapter: DdsAdapter, domain: int) -> DomainParticipant:
    return DomainParticipant(domain)


def reader(other: DomainParticipant, name: str, kind: str, qos: Qos = RELIABLE) -> DataReader[Encoded]:
    return DataReader(other, topic(other, name, kind), qos)


def test_what_a_tick_yields_is_heard_by_whoever_knows_ros_2s_names(
    robot: RosRobot, adapter: DdsAdapter, other: DomainParticipant
) -> None:
    joints = reader(other, "rt/joint_states", "sensor_msgs/msg/JointState")

    def heard() -> list[Encoded]:
        adapter.publish(robot.tick())
        return joints.take()

    (sample,) = eventually(heard)
    told = peer.JointState.deserialize(sample.data)
    assert "arm_right_1_joint" in told.name and len(told.name) == len(told.position)


def test_who_comes_late_is_told_of_the_emergency_stop(adapter: DdsAdapter, other: DomainParticipant) -> None:
    adapter.publish([Publication(STOP.topic, "std_msgs/Bool", Flag(True), 0, latched=True)])
    late = reader(other, f"rt{STOP.topic}", STOP.type, LATCHED)
    (sample,) = eventually(late.take)
    assert peer.Bool.deserialize(sample.data).data is True


def test_a_command_arrives(robot: Commanded, adapter: DdsAdapter, other: DomainParticipant) -> None:
    writer = DataWriter(other, topic(other, f"rt{BASE.topic}", BASE.type), RELIABLE)
    eventually(lambda: writer.matched_sub)
    payload = peer.Twist(peer.Vector3(0.1, 0.0, 0.0), peer.Vector3(0.0, 0.0, 0.2)).serialize()
    writer.write(Encoded(payload))
    twist = eventually(lambda: robot.commanded.get(BASE.topic))
    assert isinstance(twist, Twist) and np.array_equal(twist.velocity, (0.1, 0.0, 0.2))


def test_pictures_are_watched_while_somebody_reads_them(adapter: DdsAdapter, other: DomainParticipant) -> None:
    assert not adapter.watched()
    image = reader(other, f"rt{CAMERA.image}", "sensor_msgs/msg/Image", SENSOR)
    eventually(adapter.watched)
    del image
    eventually(lambda: not adapter.watched())


def test_every_end_is_that_of_a_node(robot: RosRobot, adapter: DdsAdapter, other: DomainParticipant) -> None:
    adapter.publish(robot.tick())
    told = reader(other, "ros_discovery_info", GRAPH, LATCHED)
    (sample,) = eventually(told.take)
    payload = sample.data
    assert payload.count(b"simulated_tiago\0") == 1
    for entity in (adapter._participant, *adapter._writers.values(), *adapter._readers.values()):
        assert entity.guid.bytes in payload
    assert {f"rt{name}" for name in robot.publications} == {writer.topic.name for writer in adapter._writers.values()}


@pytest.mark.parametrize("address", ["tcp/127.0.0.1:7447", "233", "-1"])
def test_what_is_no_domain_is_refused(robot: RosRobot, address: str) -> None:
    with pytest.raises(Refused, match="wanted the number of a DDS domain, 0 to 232"):
        connect(robot, address)


def test_a_configuration_that_cannot_work_is_refused(
    robot: RosRobot, domain: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CYCLONEDDS_URI", LOOPBACK.replace("127.0.0.1", "203.0.113.1"))
    with pytest.raises(Refused, match=f"CycloneDDS does not enter domain {domain} "):
        connect(robot, str(domain))
