"""What the simulated robot and its users say to each other, as messages of ROS 1."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from services.bridge_ros1.names import message_class
from services.ros_robot.messages import Command, Flag, Point, Publication, Trajectory, Twist, Velocities
from shared.robot.far_side import Calibration, Joints, Odometry, Picture, Wrench
from shared.robot.ros_messages import CHANNELS

_SECOND = 1_000_000_000


def written(publication: Publication) -> Any:
    """The message of a publication."""
    message, content = message_class(publication.kind)(), publication.content
    if isinstance(content, Flag):
        message.data = content.value
        return message
    header = message.header
    header.stamp = type(header.stamp)(*divmod(publication.stamp, _SECOND))
    header.frame_id = publication.frame
    match content:
        case Joints():
            message.name = list(content.names)
            message.position, message.velocity, message.effort = (
                row.tolist() for row in (content.position, content.velocity, content.effort)
            )
        case Wrench():
            _fill(message.wrench.force, content.force)
            _fill(message.wrench.torque, content.torque)
        case Odometry():
            pose, twist = message.pose.pose, message.twist.twist
            pose.position.x, pose.position.y = content.position.tolist()
            pose.orientation.z, pose.orientation.w = math.sin(content.yaw / 2.0), math.cos(content.yaw / 2.0)
            twist.linear.x, twist.linear.y, twist.angular.z = content.velocity.tolist()
        case Picture():
            message.width, message.height, message.encoding = content.width, content.height, content.encoding
            message.step, message.data = content.width * CHANNELS[content.encoding], content.data
        case Calibration():
            fx, fy, cx, cy = content.intrinsics.tolist()
            message.width, message.height = content.width, content.height
            message.D, message.distortion_model = content.distortion.tolist(), content.model
            message.K = [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0]
            message.R = np.eye(3).ravel().tolist()
            message.P = [fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0]
    return message


def read(message: Any) -> Command:
    """The command that a message is."""
    match message._type:
        case "trajectory_msgs/JointTrajectory":
            points = tuple(
                Point(
                    point.time_from_start.to_sec(),
                    np.array(point.positions),
                    np.array(point.velocities) if len(point.velocities) else None,
                )
                for point in message.points
            )
            return Trajectory(tuple(message.joint_names), points, message.header.stamp.to_nsec() or None)
        case "std_msgs/Float64MultiArray":
            return Velocities(np.array(message.data))
        case "std_msgs/Bool":
            return Flag(bool(message.data))
        case "geometry_msgs/TwistStamped":
            return Twist(_planar(message.twist), message.header.stamp.to_nsec())
    return Twist(_planar(message))


def _planar(twist: Any) -> Any:
    return np.array((twist.linear.x, twist.linear.y, twist.angular.z))


def _fill(vector: Any, values: Any) -> None:
    vector.x, vector.y, vector.z = values.tolist()
