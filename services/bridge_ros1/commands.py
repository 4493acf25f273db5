"""Commands to the robot: checked down to the last number before rospy sees them."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import Any

import numpy as np

from services.bridge_ros1.names import message_class
from shared.robot.bridge.late import give_up_late
from shared.robot.far_side import TrajectoryPoint
from shared.spatial import Array


class Unsent(ValueError):
    """A command that must not be sent; the text says why."""


def trajectory(joints: Sequence[str], points: Sequence[TrajectoryPoint]) -> Any:
    """JointTrajectory that begins as soon as it arrives.

    Raises:
        Unsent: a number is not finite or missing, a time is not after the one before, or the end is not at rest.
    """
    message, before = message_class("trajectory_msgs/JointTrajectory")(joint_names=list(joints)), 0.0
    for point in points:
        # Without a positive time the controller drops the point.
        if not before < point.after < 60.0:
            raise Unsent(f"a point is {point.after:g} s after the start, wanted more than {before:g} s")
        row = message_class("trajectory_msgs/JointTrajectoryPoint")()
        row.positions = _numbers(point.position, len(joints), "position")
        row.velocities = _numbers(point.velocity, len(joints), "velocity")
        row.time_from_start = type(row.time_from_start).from_sec(float(point.after))
        message.points.append(row)
        before = point.after
    if not message.points or any(message.points[-1].velocities):
        raise Unsent("a trajectory that does not end at rest")
    return message


def twist(velocity: Array, kind: str) -> Any:
    """Twist or TwistStamped, of now, of a velocity (3,) vx, vy [m/s], wz [rad/s].

    Raises:
        Unsent: a number is not finite or missing.
    """
    import rospy

    message = message_class(kind)()
    if hasattr(message, "header"):
        message.header.stamp = rospy.Time.now()
    inside = message.twist if hasattr(message, "twist") else message
    inside.linear.x, inside.linear.y, inside.angular.z = _numbers(velocity, 3, "velocity")
    return message


class Outlet:
    """A topic that the robot is commanded by.

    After an exception rospy's publisher keeps what it had written: the next message would end the connection, and no
    subscriber comes back. So it is given up and made anew.

    Attributes:
        topic, kind: its name and the type of its messages.
        latched: who subscribes later gets the newest message, too; to be set before there is a publisher.
        failures: commands that were not sent, and why the last one was not; empty if all were.
    """

    def __init__(self, topic: str, kind: str, latched: bool = False) -> None:
        self.topic, self.kind = topic, kind
        self.latched = latched
        self._newest: Any = None
        self.failures = ""
        self._class = message_class(kind)
        self._publisher: Any = None
        self._given_up: list[Any] = []
        self._failed = 0

    def open(self) -> None:
        """Have a publisher, in a thread that may wait for the master."""
        import rospy

        while self._given_up:
            self._given_up.pop().unregister()
        if self._publisher is None:
            self._publisher = rospy.Publisher(
                self.topic, self._class, queue_size=1, tcp_nodelay=True, latch=self.latched
            )
            if self._newest is not None:
                self._publisher.publish(self._newest)

    def give_up_late(self) -> None:
        """Have each connection end instead of delivering late."""
        publisher = self._publisher
        for connection in [*publisher.impl.connections] if publisher is not None else ():
            # It may have ended by now.
            with suppress(OSError, AttributeError):
                give_up_late(connection.socket)

    @property
    def is_open(self) -> bool:
        """Whether it has a publisher."""
        return self._publisher is not None

    @property
    def listeners(self) -> int:
        """How many subscribers are connected."""
        publisher = self._publisher
        return publisher.get_num_connections() if publisher is not None else 0

    def send(self, message: Any) -> None:
        """Publish, if there is a publisher; only the newest message waits for a slow subscriber."""
        if self.latched:
            self._newest = message
        publisher = self._publisher
        if publisher is None:
            return
        try:
            publisher.publish(message)
        except Exception as problem:
            self._publisher = None
            self._given_up.append(publisher)
            self.not_sent(f"{type(problem).__name__}: {problem}")

    def not_sent(self, why: str) -> None:
        """Count a command that was not sent."""
        self._failed += 1
        self.failures = f"{self._failed} not sent, the last one: {why}"


def _numbers(values: Array, size: int, what: str) -> list[float]:
    array = np.asarray(values, dtype=np.float64)
    if array.shape != (size,):
        raise Unsent(f"{what} has the shape {array.shape}, wanted ({size},)")
    if not np.isfinite(array).all():
        raise Unsent(f"{what} is not finite: {array}")
    return array.tolist()
