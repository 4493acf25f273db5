"""ROS messages, read by the names of their fields: what they say, and what is refused."""

from __future__ import annotations

import io
import math
from collections.abc import Callable
from types import SimpleNamespace as Message
from typing import Any

import numpy as np
import pytest
from PIL import Image

from shared.robot import ros_messages as ros

NAN = float("nan")
K = (500.0, 0.0, 320.0, 0.0, 510.0, 240.0, 0.0, 0.0, 1.0)
P = (480.0, 0.0, 319.0, 0.0, 0.0, 490.0, 239.0, 0.0, 0.0, 0.0, 1.0, 0.0)


def xyz(*values: float) -> Message:
    return Message(**dict(zip("xyzw", values, strict=False)))


def joint_state(position: Any, velocity: Any = (), effort: Any = (), name: Any = ("a", "b")) -> Message:
    return Message(name=list(name), position=position, velocity=velocity, effort=effort)


def wrench(*force: Any) -> Message:
    return Message(wrench=Message(force=xyz(*force), torque=xyz(4.0, 5.0, 6.0)), header=Message(frame_id="wrist"))


def odometry(turned: tuple[float, ...], speed: float = 0.3) -> Message:
    pose = Message(position=xyz(1.0, 2.0, 0.0), orientation=xyz(*turned))
    twist = Message(linear=xyz(speed, 0.1, 0.0), angular=xyz(0.0, 0.0, -0.2))
    return Message(pose=Message(pose=pose), twist=Message(twist=twist))


def image(encoding: str, data: bytes, step: int, width: int = 2, height: int = 2) -> Message:
    return Message(width=width, height=height, step=step, encoding=encoding, data=data)


def camera_info(k: Any = K, d: Any = (0.1, 0.2, 0.0, 0.0, 0.3)) -> Message:
    return Message(width=640, height=480, d=d, k=k, p=P, distortion_model="plumb_bob")


def test_joint_states_keep_their_order_and_what_is_left_out_is_zero() -> None:
    read = ros.joints(joint_state((1.0, 2.0), velocity=np.array((3.0, 4.0))))
    assert read.names == ("a", "b")
    assert read.position.tolist() == [1.0, 2.0] and read.velocity.tolist() == [3.0, 4.0]
    assert read.effort.tolist() == [0.0, 0.0]


def test_what_a_joint_does_not_tell_is_left_out() -> None:
    read = ros.joints(joint_state((1.0, NAN, 3.0), velocity=(NAN, NAN, 4.0), effort=(NAN, 1.0, 5.0), name="abc"))
    assert read.names == ("a", "c") and read.position.tolist() == [1.0, 3.0]
    assert read.velocity.tolist() == [0.0, 4.0] and read.effort.tolist() == [0.0, 5.0]


def test_what_is_read_is_a_copy() -> None:
    theirs = np.array((1.0, 2.0))
    read = ros.joints(joint_state(theirs))
    theirs[:] = 9.0
    assert read.position.tolist() == [1.0, 2.0]


def test_a_wrench_keeps_its_signs_and_its_frame() -> None:
    read = ros.wrench(wrench(1.0, -2.0, 3.0))
    assert read.force.tolist() == [1.0, -2.0, 3.0] and read.torque.tolist() == [4.0, 5.0, 6.0]
    assert read.frame == "wrist"


@pytest.mark.parametrize("yaw", [0.0, 1.0, -3.0])
def test_odometry_is_a_pose_in_the_plane(yaw: float) -> None:
    read = ros.odometry(odometry((0.0, 0.0, math.sin(yaw / 2.0), math.cos(yaw / 2.0))))
    assert read.yaw == pytest.approx(yaw)
    assert read.position.tolist() == [1.0, 2.0] and read.velocity.tolist() == [0.3, 0.1, -0.2]


@pytest.mark.parametrize(("encoding", "row"), [("rgb8", 6), ("bgr8", 6), ("mono8", 2)])
def test_an_image_loses_what_fills_up_its_rows(encoding: str, row: int) -> None:
    rows = [bytes(range(10 * n, 10 * n + row)) for n in (1, 2)]
    padded = b"".join(one + b"\0\0\0" for one in rows)
    read = ros.picture(image(encoding, padded, row + 3))
    assert (read.width, read.height, read.encoding, read.data) == (2, 2, encoding, b"".join(rows))
    # As rosbags hands bytes over.
    assert ros.picture(image(encoding, np.frombuffer(padded, np.uint8), row + 3)) == read


@pytest.mark.parametrize("kind", ["jpeg", "png"])
def test_the_size_of_a_compressed_image_stands_in_itself(kind: str) -> None:
    sink = io.BytesIO()
    Image.new("RGB", (33, 17)).save(sink, kind)
    read = ros.compressed(Message(format="rgb8; whatever", data=sink.getvalue()))
    assert (read.width, read.height, read.encoding, read.data) == (33, 17, kind, sink.getvalue())


def test_a_calibration_is_read_by_the_names_of_both_ros() -> None:
    second = camera_info()
    first = Message(width=640, height=480, D=second.d, K=second.k, P=second.p, distortion_model=second.distortion_model)
    for message in (first, second):
        read = ros.calibration(message)
        assert read.intrinsics.tolist() == [500.0, 510.0, 320.0, 240.0]
        assert read.distortion.tolist() == [0.1, 0.2, 0.0, 0.0, 0.3] and read.model == "plumb_bob"


def test_a_rectified_image_has_the_intrinsics_of_its_projection_and_no_distortion() -> None:
    read = ros.calibration(camera_info(), rectified=True)
    assert read.intrinsics.tolist() == [480.0, 490.0, 319.0, 239.0] and len(read.distortion) == 0


def test_a_button_of_a_joy_and_a_flag() -> None:
    assert ros.button(1)(Message(buttons=[0, 1])) is True
    assert ros.button(0)(Message(buttons=[0, 1])) is False
    assert ros.flag(Message(data=1)) is True


@pytest.mark.parametrize(
    ("read", "message", "why"),
    [
        (ros.joints, joint_state((1.0, math.inf)), "position is not finite: element 1"),
        (ros.joints, joint_state((1.0, 2.0), effort=(0.0, math.inf)), "effort is not finite"),
        (ros.joints, joint_state((1.0,)), "position has 1 elements, wanted one for each of 2 names"),
        (ros.joints, joint_state((1.0, 2.0), velocity=(1.0,)), "velocity has 1 elements"),
        (ros.joints, joint_state((1.0, "x")), "position is no list of numbers"),
        (ros.joints, joint_state((1.0, 2.0), name="aa"), "named twice"),
        (ros.wrench, wrench(1.0, NAN, 0.0), "force is not finite: element 1"),
        (ros.odometry, odometry((0.0, 0.0, 0.0, 0.0)), "no unit quaternion"),
        (ros.odometry, odometry((0.0, 0.0, 0.0, 1.0), speed=NAN), "twist is not finite"),
        (ros.picture, image("16UC1", b"\0" * 8, 4), "encoding 16UC1"),
        (ros.picture, image("rgb8", b"\0" * 11, 6), "11 bytes in rows of 6"),
        (ros.picture, image("rgb8", b"\0" * 12, 5), "rows of 5"),
        (ros.picture, image("rgb8", b"", 0, 0, 0), "no image of 0 x 0"),
        (ros.compressed, Message(format="tiff", data=b"II*\0"), "neither JPEG nor PNG .format 'tiff'"),
        (ros.compressed, Message(format="jpeg", data=b"\xff\xd8\xff\xe0\0\x04"), "no size in an image of 6 bytes"),
        (ros.calibration, camera_info(k=(0.0,) * 9), "not calibrated"),
        (ros.calibration, camera_info(d=(NAN,)), "D is not finite"),
        (ros.button(2), Message(buttons=[0, 1]), "2 buttons, and number 2"),
    ],
)
def test_what_is_of_no_use_is_refused_with_its_reason(read: Callable[[Any], Any], message: Any, why: str) -> None:
    with pytest.raises(ros.Unreadable, match=why):
        read(message)
