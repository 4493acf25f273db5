"""What the simulated robot and its users say to each other, as fields of ROS 2 messages.

Types come from another release than the bridge reads them with; no code is shared with it.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_typestore

from services.ros_robot.messages import Command, Content, Flag, Point, Publication, Trajectory, Twist, Velocities
from shared.robot.far_side import Calibration, Joints, Odometry, Picture, Wrench
from shared.robot.ros_messages import CHANNELS

STORE = get_typestore(Stores.ROS2_JAZZY)
_SECOND = 1_000_000_000


def of_ros2(kind: str) -> str:
    """A type such as ``std_msgs/Bool`` as ROS 2 writes it."""
    return kind.replace("/", "/msg/")


def definition(kind: str) -> str:
    """The text that defines a type of ROS 2, with those inside it."""
    return STORE.generate_msgdef(kind, ros_version=2)[0]


def fields(publication: Publication) -> dict[str, Any]:
    """Fields of the message of a publication."""
    content = publication.content
    if isinstance(content, Flag):
        return {"data": content.value}
    stamp = _new("builtin_interfaces/Time", sec=publication.stamp // _SECOND, nanosec=publication.stamp % _SECOND)
    return {"header": _new("std_msgs/Header", stamp=stamp, frame_id=publication.frame), **_fields(content)}


def read(message: Any) -> Command:
    """The command that a message is."""
    match message.__msgtype__:
        case "trajectory_msgs/msg/JointTrajectory":
            points = tuple(
                Point(
                    1e-9 * _nanoseconds(point.time_from_start),
                    np.array(point.positions),
                    np.array(point.velocities) if len(point.velocities) else None,
                )
                for point in message.points
            )
            return Trajectory(tuple(message.joint_names), points, _nanoseconds(message.header.stamp) or None)
        case "std_msgs/msg/Float64MultiArray":
            return Velocities(np.array(message.data))
        case "std_msgs/msg/Bool":
            return Flag(bool(message.data))
        case "geometry_msgs/msg/TwistStamped":
            return Twist(_planar(message.twist), _nanoseconds(message.header.stamp))
    return Twist(_planar(message))


def _fields(content: Content) -> dict[str, Any]:
    match content:
        case Joints():
            arrays = {name: _array(getattr(content, name)) for name in ("position", "velocity", "effort")}
            return {"name": list(content.names), **arrays}
        case Wrench():
            return {"wrench": _new("geometry_msgs/Wrench", force=_xyz(content.force), torque=_xyz(content.torque))}
        case Odometry():
            half = content.yaw / 2.0
            turned = _new("geometry_msgs/Quaternion", x=0.0, y=0.0, z=math.sin(half), w=math.cos(half))
            x, y = content.position.tolist()
            vx, vy, wz = content.velocity.tolist()
            place = _new("geometry_msgs/Pose", position=_point(x, y), orientation=turned)
            motion = _new("geometry_msgs/Twist", linear=_xyz((vx, vy, 0.0)), angular=_xyz((0.0, 0.0, wz)))
            return {
                "child_frame_id": "base_footprint",
                "pose": _new("geometry_msgs/PoseWithCovariance", pose=place, covariance=np.zeros(36)),
                "twist": _new("geometry_msgs/TwistWithCovariance", twist=motion, covariance=np.zeros(36)),
            }
        case Picture(width, height, encoding, data):
            size = {"width": width, "height": height, "step": width * CHANNELS[encoding]}
            return {**size, "encoding": encoding, "is_bigendian": 0, "data": np.frombuffer(data, np.uint8)}
        case Calibration():
            fx, fy, cx, cy = content.intrinsics.tolist()
            return {
                "width": content.width,
                "height": content.height,
                "distortion_model": content.model,
                "d": _array(content.distortion),
                "k": np.array((fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0)),
                "r": np.eye(3).ravel(),
                "p": np.array((fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0)),
                "binning_x": 0,
                "binning_y": 0,
                "roi": _new(
                    "sensor_msgs/RegionOfInterest", x_offset=0, y_offset=0, height=0, width=0, do_rectify=False
                ),
            }
    raise TypeError(f"{type(content).__name__} has no message")


def _new(kind: str, **values: Any) -> Any:
    return STORE.types[of_ros2(kind)](**values)


def _array(values: Any) -> np.ndarray:
    return np.ascontiguousarray(values, dtype=np.float64)


def _xyz(values: Any) -> Any:
    x, y, z = (float(value) for value in values)
    return _new("geometry_msgs/Vector3", x=x, y=y, z=z)


def _point(x: float, y: float) -> Any:
    return _new("geometry_msgs/Point", x=x, y=y, z=0.0)


def _planar(twist: Any) -> np.ndarray:
    return np.array((twist.linear.x, twist.linear.y, twist.angular.z))


def _nanoseconds(time: Any) -> int:
    return int(time.sec) * _SECOND + int(time.nanosec)
