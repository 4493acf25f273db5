"""What the robot and its users say to each other, as plain data: each middleware writes it in its own way.

A ``stamp`` is in ns of the robot's clock, which counts from 1970 as ROS' does.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from shared.robot.far_side import Calibration, Joints, Odometry, Picture, Wrench
from shared.spatial import Array

Middleware = Literal["ros1", "ros2"]


@dataclass(frozen=True, slots=True)
class Point:
    """Where joints are to be, positions (n,) [rad, m], so long [s] after the trajectory's start.

    Attributes:
        velocity: (n,) [rad/s, m/s]; None if the message has none.
    """

    after: float
    position: Array
    velocity: Array | None = None


@dataclass(frozen=True, slots=True)
class Trajectory:
    """For a joint trajectory controller: the joints in the order of the points' numbers.

    Attributes:
        start: [ns] of the robot's clock; None to start on arrival (a stamp of zero).
    """

    joints: tuple[str, ...]
    points: tuple[Point, ...]
    start: int | None = None


@dataclass(frozen=True, slots=True)
class Velocities:
    """For a group velocity controller: of all its joints (n,) [rad/s, m/s]."""

    values: Array


@dataclass(frozen=True, slots=True)
class Twist:
    """For the base: vx, vy [m/s], wz [rad/s] (3,); with the stamp of a ``TwistStamped``."""

    velocity: Array
    stamp: int | None = None


@dataclass(frozen=True, slots=True)
class Flag:
    """A ``Bool``."""

    value: bool


Command = Trajectory | Velocities | Twist | Flag
Content = Joints | Wrench | Odometry | Picture | Calibration | Flag


@dataclass(frozen=True, slots=True)
class Publication:
    """One message that the robot publishes.

    Attributes:
        topic: with its leading slash.
        kind: the ROS type, ``sensor_msgs/JointState``; ROS 2 puts ``msg`` in between.
        stamp: for the header, if the type has one.
        frame: for the header.
        latched: whether who comes later is to get it too (transient local).
        node: that publishes it, by name: of one planted mistake a second one does.
    """

    topic: str
    kind: str
    content: Content
    stamp: int
    frame: str = ""
    latched: bool = False
    node: str = "robot"


@dataclass(frozen=True, slots=True)
class ControllerState:
    """A row of ``controller_manager/list_controllers``.

    Attributes:
        state: "running" or "stopped" in ROS 1, "active" or "inactive" in ROS 2.
        kind: class of the controller as the middleware names it.
    """

    name: str
    state: str
    kind: str
    joints: tuple[str, ...]
