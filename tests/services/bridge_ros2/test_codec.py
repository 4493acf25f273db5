"""Messages as bytes, held against CycloneDDS: what it writes is read, and what is written it would write, too."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from services.bridge_ros2.codec import decode, encode, new, numbers, type_hash
from services.bridge_ros2.commands import Unsent, trajectory, twist
from shared.robot import ros_messages as ros
from shared.robot.far_side import TrajectoryPoint
from shared.robot.profile import Profile
from shared.robot.ros_messages import Unreadable
from tests.services.bridge_ros2 import peer

finite = st.floats(allow_nan=False, allow_infinity=False)
three = st.tuples(finite, finite, finite)
name = st.text(st.characters(codec="ascii", exclude_characters="\0"), max_size=20)
NOW = peer.Header(peer.Time(0, 0), "")
KINDS = sorted(set(Profile.load("tiago-ros2").heard().values()) | {"sensor_msgs/msg/CompressedImage"})


@given(st.integers(0, 2**31 - 1), st.integers(0, 10**9 - 1), name, three, three)
def test_a_wrench_of_the_peer_is_read(sec: int, nanosec: int, frame: str, force: tuple, torque: tuple) -> None:
    wrench = peer.Wrench(peer.Vector3(*force), peer.Vector3(*torque))
    message = decode(
        peer.WrenchStamped(peer.Header(peer.Time(sec, nanosec), frame), wrench).serialize(),
        "geometry_msgs/msg/WrenchStamped",
    )
    read = ros.wrench(message)
    assert (read.force.tolist(), read.torque.tolist(), read.frame) == ([*force], [*torque], frame)
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (sec, nanosec)


@given(st.lists(st.tuples(name, finite, finite, finite), max_size=30, unique_by=lambda row: row[0]))
def test_joint_states_of_the_peer_are_read(rows: list[tuple[str, float, float, float]]) -> None:
    names, *columns = zip(*rows, strict=True) if rows else ((), (), (), ())
    payload = peer.JointState(NOW, list(names), *(list(column) for column in columns)).serialize()
    read = ros.joints(decode(payload, "sensor_msgs/msg/JointState"))
    assert read.names == names
    for array, column in zip((read.position, read.velocity, read.effort), columns, strict=True):
        assert array.tolist() == [*column]


def test_odometry_and_images_of_the_peer_are_read() -> None:
    pose = peer.Pose(peer.Vector3(1.0, 2.0, 0.0), peer.Quaternion(0.0, 0.0, 1.0, 0.0))
    motion = peer.Twist(peer.Vector3(0.3, -0.1, 0.0), peer.Vector3(0.0, 0.0, 0.5))
    zeros = [0.0] * 36
    told = peer.Odometry(NOW, "base", peer.PoseWithCovariance(pose, zeros), peer.TwistWithCovariance(motion, zeros))
    read = ros.odometry(decode(told.serialize(), "nav_msgs/msg/Odometry"))
    assert read.position.tolist() == [1.0, 2.0] and read.velocity.tolist() == [0.3, -0.1, 0.5]
    assert read.yaw == pytest.approx(np.pi)
    image = peer.Image(NOW, 2, 3, "mono8", 0, 4, [1, 2, 3, 0, 4, 5, 6, 0])
    picture = ros.picture(decode(image.serialize(), "sensor_msgs/msg/Image"))
    assert (picture.width, picture.height, picture.data) == (3, 2, bytes((1, 2, 3, 4, 5, 6)))


@pytest.mark.parametrize("payload", [b"\0\1\0\0\1", b"\0\1\0\0\1\0\0\0"], ids=["rmw_zenoh", "DDS"])
def test_a_bool_may_be_filled_up(payload: bytes) -> None:
    assert ros.flag(decode(payload, "std_msgs/msg/Bool")) is True


@given(st.sampled_from(KINDS), st.binary(max_size=400) | st.binary(max_size=400).map(lambda end: b"\0\1\0\0" + end))
def test_whatever_is_no_message_is_refused_in_one_line(kind: str, payload: bytes) -> None:
    try:
        decode(payload, kind)
    except Unreadable as problem:
        assert kind in str(problem) and "\n" not in str(problem)


def test_a_message_that_is_cut_off_is_refused() -> None:
    payload = peer.JointState(NOW, ["a", "b"], [1.0, 2.0], [0.0, 0.0], [0.0, 0.0]).serialize()
    for end in range(len(payload)):
        with pytest.raises(Unreadable):
            decode(payload[:end], "sensor_msgs/msg/JointState")


@given(three)
def test_a_twist_is_what_the_peer_writes(velocity: tuple[float, float, float]) -> None:
    vx, vy, wz = velocity
    told = peer.Twist(peer.Vector3(vx, vy, 0.0), peer.Vector3(0.0, 0.0, wz))
    assert twist(np.array(velocity), "geometry_msgs/msg/Twist", 5) == told.serialize()
    stamped = peer.TwistStamped(peer.Header(peer.Time(3, 7), ""), told)
    assert twist(np.array(velocity), "geometry_msgs/msg/TwistStamped", 3 * 10**9 + 7) == stamped.serialize()


@given(st.lists(st.tuples(name, finite, finite), min_size=1, max_size=9))
def test_a_trajectory_is_what_the_peer_writes(rows: list[tuple[str, float, float]]) -> None:
    names, places, speeds = (list(column) for column in zip(*rows, strict=True))
    rest = [0.0] * len(rows)
    points = [
        TrajectoryPoint(0.06, np.array(places), np.array(speeds)),
        TrajectoryPoint(1.2, np.array(places), np.array(rest)),
    ]
    told = peer.JointTrajectory(
        NOW,
        names,
        [
            peer.Point(places, speeds, [], [], peer.Time(0, 60_000_000)),
            peer.Point(places, rest, [], [], peer.Time(1, 200_000_000)),
        ],
    )
    assert trajectory(names, points) == told.serialize()


def test_integers_are_sent_as_the_numbers_that_they_are() -> None:
    ones = np.ones(2, dtype=int)
    payload = trajectory(["a", "b"], [TrajectoryPoint(0.1, ones, 0 * ones)])
    (point,) = decode(payload, "trajectory_msgs/msg/JointTrajectory").points
    assert point.positions.tolist() == [1.0, 1.0]
    wrong_order = np.asfortranarray(np.arange(8.0).reshape(4, 2))[::2, 0]
    (point,) = decode(
        trajectory(["a", "b"], [TrajectoryPoint(0.1, wrong_order, 0 * ones)]), "trajectory_msgs/msg/JointTrajectory"
    ).points
    assert point.positions.tolist() == [0.0, 4.0]


@pytest.mark.parametrize(
    ("points", "why"),
    [
        ([(0.0, (0.0, 0.0), (0.0, 0.0))], "a point is 0 s after the start, wanted 0 to 60 s"),
        ([(0.2, (0.0, 0.0), (0.0, 0.0)), (0.1, (0.0, 0.0), (0.0, 0.0))], "a point is 0.1 s"),
        ([(np.nan, (0.0, 0.0), (0.0, 0.0))], "a point is nan s"),
        ([(0.1, (0.0, np.nan), (0.0, 0.0))], "position is not finite"),
        ([(0.1, (0.0, 0.0), (np.inf, 0.0))], "velocity is not finite"),
        ([(0.1, (0.0,), (0.0, 0.0))], r"position has the shape \(1,\), wanted \(2,\)"),
        ([(0.1, (0.0, 0.0), (0.1, 0.0))], "does not end at rest"),
        ([], "does not end at rest"),
    ],
)
def test_a_trajectory_that_must_not_be_sent(points: list[tuple[float, tuple, tuple]], why: str) -> None:
    with pytest.raises(Unsent, match=why):
        trajectory(["a", "b"], [TrajectoryPoint(after, np.array(q), np.array(v)) for after, q, v in points])


@pytest.mark.parametrize("velocity", [(0.0, 0.0), (0.0, np.nan, 0.0), (0.0, 0.0, -np.inf)])
def test_a_velocity_that_must_not_be_sent(velocity: tuple[float, ...]) -> None:
    with pytest.raises(Unsent, match="velocity"):
        twist(np.array(velocity), "geometry_msgs/msg/Twist", 0)


def test_types_have_the_hashes_that_ros_gives_them() -> None:
    assert type_hash("geometry_msgs/msg/Twist").startswith("RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e60")
    assert type_hash("trajectory_msgs/msg/JointTrajectory").endswith("7ca2f64b2f3928f4a018cec115e213796e")


def test_a_message_of_ones_own_comes_back() -> None:
    payload = encode(new("std_msgs/msg/Bool", data=True))
    assert ros.flag(decode(payload, "std_msgs/msg/Bool")) and numbers((1, 2)).dtype == np.float64
