"""What ROS messages say, checked: they are read by the names of their fields, which ROS 1 and ROS 2 share.

Each function takes a message as a ROS library decodes it, copies what it needs, and raises `Unreadable` for anything
that is of no use: a wrong shape, a number that is not finite, an image of an unknown encoding.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from shared.robot.far_side import Calibration, Joints, Odometry, Picture, Wrench
from shared.robot.profile import Profile
from shared.spatial import Array

CHANNELS = {"rgb8": 3, "bgr8": 3, "mono8": 1}
"""Bytes of a pixel by the encodings that the contract has, too."""
_FRAME_OF_JPEG = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}


class Unreadable(ValueError):
    """A message that nothing can be learnt from; the text says why."""


def joints(message: Any) -> Joints:
    """JointState; velocities and efforts that a robot leaves out are zero, joints without a position are left out.

    A joint_state_broadcaster leaves out by a NaN what the hardware of a joint does not tell (ros2_controllers #1776).
    """
    names = tuple(message.name)
    if len(set(names)) != len(names):
        raise Unreadable(f"a joint is named twice: {', '.join(names)}")
    size = len(names)

    def of_all(field: str, may_lack: bool) -> Array:
        values = getattr(message, field)
        if may_lack and len(values) == 0:
            return np.zeros(size)
        array = _numbers(values, field, gaps=True)
        if len(array) != size:
            raise Unreadable(f"{field} has {len(array)} elements, wanted one for each of {size} names")
        return np.nan_to_num(array) if may_lack else array

    position, velocity, effort = of_all("position", False), of_all("velocity", True), of_all("effort", True)
    told = ~np.isnan(position)
    if not told.all():
        names = tuple(name for name, there in zip(names, told.tolist(), strict=True) if there)
    return Joints(names, position[told], velocity[told], effort[told])


def wrench(message: Any) -> Wrench:
    """WrenchStamped."""
    force, torque = message.wrench.force, message.wrench.torque
    return Wrench(_xyz(force, "force"), _xyz(torque, "torque"), str(message.header.frame_id))


def odometry(message: Any) -> Odometry:
    """Odometry, as a pose in the plane."""
    pose, twist = message.pose.pose, message.twist.twist
    turned = pose.orientation
    x, y, z, w = _numbers((turned.x, turned.y, turned.z, turned.w), "orientation").tolist()
    if not 0.9 < x * x + y * y + z * z + w * w < 1.1:
        raise Unreadable(f"orientation ({x:g}, {y:g}, {z:g}, {w:g}) is no unit quaternion")
    yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    position = _numbers((pose.position.x, pose.position.y), "position")
    return Odometry(position, yaw, _numbers((twist.linear.x, twist.linear.y, twist.angular.z), "twist"))


def picture(message: Any) -> Picture:
    """Image, without what may fill up its rows."""
    width, height, step, encoding = int(message.width), int(message.height), int(message.step), str(message.encoding)
    if encoding not in CHANNELS:
        raise Unreadable(f"encoding {encoding or 'missing'}, wanted {', '.join(CHANNELS)} or a compressed topic")
    data, row = bytes(memoryview(message.data)), width * CHANNELS[encoding]
    if width < 1 or height < 1 or step < row or len(data) < step * height:
        raise Unreadable(f"{len(data)} bytes in rows of {step} are no image of {width} x {height} in {encoding}")
    if step != row:
        data = np.frombuffer(data, np.uint8, step * height).reshape(height, step)[:, :row].tobytes()
    return Picture(width, height, encoding, data[: row * height])


def compressed(message: Any) -> Picture:
    """CompressedImage of JPEG or PNG, whatever its format says; the size stands in the image itself."""
    data = bytes(memoryview(message.data))
    if data[:8] == b"\x89PNG\r\n\x1a\n" and len(data) > 24:
        encoding = "png"
        width, height = int.from_bytes(data[16:20], "big"), int.from_bytes(data[20:24], "big")
    elif data[:2] == b"\xff\xd8":
        encoding, (width, height) = "jpeg", _size_of_jpeg(data)
    else:
        raise Unreadable(f"neither JPEG nor PNG (format {str(message.format)!r})")
    if width < 1 or height < 1:
        raise Unreadable(f"no size in an image of {len(data)} bytes")
    return Picture(width, height, encoding, data)


def calibration(message: Any, rectified: bool = False) -> Calibration:
    """CameraInfo.

    Args:
        message: with D, K and P as ROS 1 calls them, or d, k and p as ROS 2 does.
        rectified: whether the image is: it has no distortion then, and the intrinsics of P.
    """
    D, K, P = (getattr(message, name, None) for name in "DKP")
    if K is None:
        D, K, P = message.d, message.k, message.p
    matrix, row = (_numbers(P, "P"), 4) if rectified else (_numbers(K, "K"), 3)
    if len(matrix) != 3 * row or matrix[0] <= 0.0 or matrix[row + 1] <= 0.0:
        raise Unreadable("K or P has no focal length: the camera is not calibrated")
    intrinsics = matrix[[0, row + 1, 2, row + 2]]
    distortion = np.zeros(0) if rectified else _numbers(D, "D")
    return Calibration(int(message.width), int(message.height), intrinsics, distortion, str(message.distortion_model))


def flag(message: Any) -> bool:
    """Bool."""
    return bool(message.data)


def button(number: int) -> Callable[[Any], bool]:
    """Whether that button of a Joy is pressed."""

    def pressed(message: Any) -> bool:
        if number >= len(message.buttons):
            raise Unreadable(f"{len(message.buttons)} buttons, and number {number} is the enabling device")
        return bool(message.buttons[number])

    return pressed


def readers(profile: Profile) -> Iterator[tuple[str, Callable[[Any], Any]]]:
    """Topics that the robot of a profile publishes, but for its emergency stop, and how their messages are read."""
    yield profile.joints.topic, joints
    yield profile.wrench.topic, wrench
    if profile.base:
        yield profile.base.odometry, odometry
    if camera := profile.camera:
        rectified = "rect" in camera.image
        yield camera.image, compressed if camera.image.endswith("/compressed") else picture
        yield camera.info, lambda message: calibration(message, rectified)
    if enable := profile.enable:
        yield enable.topic, button(enable.button) if enable.type.endswith("/Joy") else flag


def _numbers(values: Any, what: str, gaps: bool = False) -> Array:
    """A copy of them, every one finite, or not a number where there may be gaps."""
    try:
        array: Array = np.array(values, dtype=np.float64).reshape(-1)
    except (TypeError, ValueError):
        raise Unreadable(f"{what} is no list of numbers") from None
    sound = ~np.isinf(array) if gaps else np.isfinite(array)
    if not sound.all():
        raise Unreadable(f"{what} is not finite: element {int(np.argmin(sound))}")
    return array


def _xyz(vector: Any, what: str) -> Array:
    return _numbers((vector.x, vector.y, vector.z), what)


def _size_of_jpeg(data: bytes) -> tuple[int, int]:
    """Width and height from the frame's header; zeros if there is none."""
    at = 2
    while at + 9 <= len(data) and data[at] == 0xFF:
        marker, length = data[at + 1], int.from_bytes(data[at + 2 : at + 4], "big")
        if marker in _FRAME_OF_JPEG:
            return int.from_bytes(data[at + 7 : at + 9], "big"), int.from_bytes(data[at + 5 : at + 7], "big")
        at += 2 + length
    return 0, 0
