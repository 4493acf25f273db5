"""A joint trajectory controller, as ``joint_trajectory_controller`` of ROS 1 and of ROS 2 behaves.

What matters to whoever commands it: a message replaces the trajectory at once, with a spline from the set-point of that
instant; all joints have to be named, in any order; a point that lies in the past is dropped in ROS 1 and jumped to in
ROS 2; the last point is held.
"""

from __future__ import annotations

import bisect
import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from services.ros_robot.messages import Middleware, Point, Trajectory
from shared.spatial import Array


@dataclass(frozen=True, slots=True)
class _Knot:
    """Set-points (n,) at a time [s], and whether the way there is straight: to a point without velocities it is."""

    time: float
    position: Array
    velocity: Array
    straight: bool = False


class JointTrajectoryController:
    """Turns trajectories into set-points.

    Attributes:
        name: of the controller.
        joints: that it moves, in the order of its set-points.
        running: whether it moves them; what arrives while it does not is refused.

    Args:
        middleware: whose controller it is.
        name, joints: see above.
        position: of the joints (n,) [rad, m] at the start.
    """

    def __init__(self, middleware: Middleware, name: str, joints: Sequence[str], position: Array) -> None:
        self.name = name
        self.joints = tuple(joints)
        self.running = False
        self._drops_the_past = middleware == "ros1"
        self._knots: list[_Knot] = []
        self.hold(position)

    def hold(self, position: Array) -> None:
        """Forget the trajectory, and hold positions (n,) [rad, m]."""
        self._knots = [_Knot(-np.inf, np.array(position, dtype=float), np.zeros(len(self.joints)))]

    def command(self, message: Trajectory, now: float, start: float) -> str:
        """Follow a trajectory instead of the present one.

        Args:
            message: as it arrived.
            now: time [s] of its arrival.
            start: time [s] that its points count from.

        Returns:
            Why it is refused; empty if it is followed. What was followed before goes on then.
        """
        refusal = self._refusal(message)
        if refusal:
            return refusal
        order = [message.joints.index(joint) for joint in self.joints]
        knots = [_knot(point, start, order) for point in message.points]
        coming = [knot for knot in knots if knot.time > now]
        if self._drops_the_past:
            if not coming:
                return f"all {len(knots)} points lie in the past: give each a positive time_from_start"
            knots = coming
        if len(knots) == len(coming):
            # From where the set-point is when the trajectory starts; until then the present one goes on.
            begin = max(now, start)
            present = self._knots[self._at(now) :]
            kept = [knot for knot in present if now < begin > knot.time]
            straight = any(knot.straight for knot in present[len(kept) :][:1])
            knots = [*kept, _Knot(begin, *self.sample(begin), straight), *knots]
        self._knots = knots
        return ""

    def sample(self, now: float) -> tuple[Array, Array]:
        """Set-points at a time [s]: positions (n,) [rad, m] and velocities (n,)."""
        at = self._at(now)
        if at + 1 == len(self._knots) or now < self._knots[at].time:
            return self._knots[at].position, np.zeros(len(self.joints))
        return _between(self._knots[at], self._knots[at + 1], now)

    def _at(self, now: float) -> int:
        """Index of the last knot up to now; of the first one if all are to come."""
        return max(0, bisect.bisect_right(self._knots, now, key=lambda knot: knot.time) - 1)

    def _refusal(self, message: Trajectory) -> str:
        if not self.running:
            return f"{self.name} is not running"
        if set(message.joints) != set(self.joints) or len(message.joints) != len(self.joints):
            missing = ", ".join(joint for joint in self.joints if joint not in message.joints) or "none"
            strange = ", ".join(joint for joint in message.joints if joint not in self.joints) or "none"
            return f"{self.name} wants all its {len(self.joints)} joints once; missing: {missing}; strange: {strange}"
        if not message.points:
            return "there is no point"
        times = [point.after for point in message.points]
        if any(later <= earlier for earlier, later in itertools.pairwise(times)):
            return "time_from_start does not grow from point to point"
        for point in message.points:
            for values in (point.position, point.velocity):
                if values is not None and (len(values) != len(self.joints) or not np.isfinite(values).all()):
                    return f"a point has other than {len(self.joints)} finite numbers"
        return ""


def _knot(point: Point, start: float, order: list[int]) -> _Knot:
    time, position = start + point.after, np.asarray(point.position, dtype=float)[order]
    if point.velocity is None:
        return _Knot(time, position, np.zeros(len(order)), True)
    return _Knot(time, position, np.asarray(point.velocity, dtype=float)[order])


def _between(before: _Knot, after: _Knot, now: float) -> tuple[Array, Array]:
    """Position and velocity on the straight line, or on the cubic that has both positions and both velocities."""
    length = after.time - before.time
    share = (now - before.time) / length
    way = after.position - before.position
    if after.straight:
        return before.position + share * way, way / length
    first, last = length * before.velocity, length * after.velocity
    bend = 3.0 * way - 2.0 * first - last
    curl = first + last - 2.0 * way
    position = before.position + share * (first + share * (bend + share * curl))
    return position, (first + share * (2.0 * bend + 3.0 * share * curl)) / length
