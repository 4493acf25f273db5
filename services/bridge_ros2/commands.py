"""Commands to the robot, checked down to the last number before they are encoded: nobody behind checks them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from services.bridge_ros2.codec import encode, new, numbers
from shared.clock import nanoseconds
from shared.robot.far_side import TrajectoryPoint
from shared.spatial import Array

LONGEST = 60.0  # [s] of a trajectory
_SECOND = 1_000_000_000
_NOTHING = numbers(())


class Unsent(ValueError):
    """A command that must not be sent; the text says why."""


def trajectory(joints: Sequence[str], points: Sequence[TrajectoryPoint]) -> bytes:
    """JointTrajectory that begins as soon as it arrives.

    Raises:
        Unsent: a number is not finite or missing, a time is not after the one before, or the end is not at rest.
    """
    rows, before = [], 0.0
    for point in points:
        # A point at time 0 is a step of the set-point.
        if not before < point.after < LONGEST:
            raise Unsent(f"a point is {point.after:g} s after the start, wanted {before:g} to {LONGEST:g} s")
        before = point.after
        rows.append(
            new(
                "trajectory_msgs/msg/JointTrajectoryPoint",
                positions=_checked(point.position, len(joints), "position"),
                velocities=_checked(point.velocity, len(joints), "velocity"),
                accelerations=_NOTHING,
                effort=_NOTHING,
                time_from_start=_time("Duration", nanoseconds(point.after)),
            )
        )
    if not rows or rows[-1].velocities.any():
        raise Unsent("a trajectory that does not end at rest")
    # A stamp of zero means now, whatever the robot's clock says.
    header = _header(0)
    return encode(new("trajectory_msgs/msg/JointTrajectory", header=header, joint_names=list(joints), points=rows))


def twist(velocity: Array, kind: str, stamp: int) -> bytes:
    """Twist or TwistStamped of a velocity (3,) vx, vy [m/s], wz [rad/s].

    Args:
        velocity: of the base, in its axes.
        kind: the message's type.
        stamp: [ns] of the robot's clock, for those that have one.

    Raises:
        Unsent: a number is not finite or missing.
    """
    vx, vy, wz = _checked(velocity, 3, "velocity").tolist()
    message = new("geometry_msgs/msg/Twist", linear=_vector(vx, vy, 0.0), angular=_vector(0.0, 0.0, wz))
    if kind.endswith("Stamped"):
        message = new(kind, header=_header(stamp), twist=message)
    return encode(message)


def _header(stamp: int) -> Any:
    return new("std_msgs/msg/Header", stamp=_time("Time", stamp), frame_id="")


def _time(kind: str, time: int) -> Any:
    return new(f"builtin_interfaces/msg/{kind}", sec=time // _SECOND, nanosec=time % _SECOND)


def _vector(x: float, y: float, z: float) -> Any:
    return new("geometry_msgs/msg/Vector3", x=x, y=y, z=z)


def _checked(values: Array, size: int, what: str) -> np.ndarray:
    array = numbers(values)
    if array.shape != (size,):
        raise Unsent(f"{what} has the shape {array.shape}, wanted ({size},)")
    if not np.isfinite(array).all():
        raise Unsent(f"{what} is not finite: {array}")
    return array
