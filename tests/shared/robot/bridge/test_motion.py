"""Motion of joints: whatever is wanted, an ideal spline controller does it within every limit, and ends at rest."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from services.ros_robot.messages import Point, Trajectory
from services.ros_robot.trajectory_controller import JointTrajectoryController
from shared.robot.bridge.motion import BRAKING, RAMP, REST_WITHIN, SLACK, JointMotion
from shared.robot.far_side import TrajectoryPoint

LOWER, UPPER = np.array((0.0, -1.0, -2.0)), np.array((0.35, 1.0, 2.0))
SPEED, ACCELERATION = np.array((0.07, 2.0, 1.5)), np.array((2.0, 10.0, 8.0))
NAMES = ("lift", "shoulder", "elbow")
PERIOD, STEP = 0.02, 0.002
ROUNDING = 1e-9

shares = st.tuples(*[st.floats(0.0, 1.0)] * 3).map(np.array)
speeds = st.tuples(*[st.floats(-3.0, 3.0) | st.just(0.0)] * 3).map(np.array)


class Follower:
    """An ideal spline controller that is told what the motion says."""

    def __init__(self, position: np.ndarray) -> None:
        self.motion = JointMotion(LOWER, UPPER, SPEED, ACCELERATION)
        self.motion.start(position)
        self.controller = JointTrajectoryController("ros1", "arm", NAMES, position)
        self.controller.running = True
        self.now = self.told = 0.0
        self.executed = [(position, np.zeros(3))]

    def tell(self, wanted: np.ndarray, late: float = 0.0) -> list[TrajectoryPoint]:
        points = self.motion.tell(*self.motion.at(self.now - self.told), wanted)
        self.told = self.now
        self.run(late)
        knots = tuple(Point(point.after, point.position, point.velocity) for point in points)
        assert self.controller.command(Trajectory(NAMES, knots), self.now, self.now) == ""
        return points

    def run(self, duration: float) -> None:
        for _ in range(round(duration / STEP)):
            self.now += STEP
            self.executed.append(self.controller.sample(self.now))

    @property
    def state(self) -> tuple[np.ndarray, np.ndarray]:
        return self.executed[-1]


def inside(position: np.ndarray, more: float = ROUNDING) -> bool:
    return bool((position >= LOWER - more).all() and (position <= UPPER + more).all())


@settings(max_examples=150, deadline=None)
@given(start=shares, wanted=st.lists(speeds, max_size=30))
def test_all_limits_are_kept_and_whenever_commands_end_the_joints_come_to_rest(
    start: np.ndarray, wanted: list[np.ndarray]
) -> None:
    follower = Follower(LOWER + start * (UPPER - LOWER))
    for speed in wanted:
        follower.tell(speed)
        follower.run(PERIOD)
    follower.run(REST_WITHIN)
    positions, velocities = (np.array(part) for part in zip(*follower.executed, strict=True))
    assert all(inside(position) for position in positions)
    assert (np.abs(velocities) <= follower.motion.speed + ROUNDING).all()
    assert (np.abs(np.diff(velocities, axis=0)) <= STEP * ACCELERATION + 1e-6).all()
    assert follower.state[1] == pytest.approx(np.zeros(3), abs=1e-6)


@settings(max_examples=100, deadline=None)
@given(wanted=st.lists(speeds, min_size=1, max_size=20), period=st.sampled_from((0.006, 0.01, 0.02, 0.05, 0.1, 0.3)))
def test_the_set_point_is_where_the_controller_is_however_seldom_it_is_told(
    wanted: list[np.ndarray], period: float
) -> None:
    follower = Follower(0.5 * (LOWER + UPPER))
    for speed in wanted:
        follower.tell(speed)
        follower.run(period)
        position, velocity = follower.motion.at(follower.now - follower.told)
        assert follower.state[0] == pytest.approx(position, abs=1e-6)
        assert follower.state[1] == pytest.approx(velocity, abs=1e-6)


@settings(max_examples=100, deadline=None)
@given(wanted=st.lists(st.tuples(speeds, st.integers(0, 10)), max_size=20))
def test_trajectories_that_arrive_late_still_end_at_rest_near_the_limits(
    wanted: list[tuple[np.ndarray, int]],
) -> None:
    follower = Follower(0.5 * (LOWER + UPPER))
    for speed, late in wanted:
        follower.tell(speed, late=late * STEP)
        follower.run(PERIOD)
    follower.run(REST_WITHIN)
    assert follower.state[1] == pytest.approx(np.zeros(3), abs=1e-6)
    # A joint has gone on for so long.
    assert inside(follower.state[0], 0.02 * SPEED.max())


@given(wanted=speeds.filter(lambda speed: np.abs(speed).max() > 1e-3))
def test_a_speed_that_is_possible_is_reached_along_a_straight_line(wanted: np.ndarray) -> None:
    follower = Follower(0.5 * (LOWER + UPPER))
    wanted = wanted * min(1.0, 0.9 / float((np.abs(wanted) / follower.motion.speed).max()))
    before = follower.state[0]
    for _ in range(12):
        follower.tell(wanted)
        follower.run(PERIOD)
    position, velocity = follower.state
    assert velocity == pytest.approx(wanted, rel=0.01, abs=1e-9)
    way = position - before
    assert way == pytest.approx(wanted * float(way @ wanted / (wanted @ wanted)), abs=1e-9)


def test_to_come_to_rest_takes_no_longer_than_braking_does() -> None:
    follower = Follower(np.array((0.1, 0.0, 0.0)))
    for _ in range(10):
        follower.tell(np.array((0.07, 1.4, -1.2)))
        follower.run(PERIOD)
    (point,) = follower.tell(np.zeros(3))
    assert point.after <= BRAKING + ROUNDING
    follower.run(BRAKING + STEP)
    assert not follower.state[1].any()
    assert follower.motion.ends


def test_the_first_trajectory_ramps_within_the_time_that_a_late_one_may_miss() -> None:
    points = Follower(np.array((0.1, 0.0, 0.0))).tell(np.array((0.05, 0.1, 0.1)))
    assert points[0].after == RAMP
    assert [point.after for point in points] == sorted(point.after for point in points)
    assert not points[-1].velocity.any()
    assert points[-1].after <= REST_WITHIN + ROUNDING


def test_a_set_point_stays_near_joints_that_are_held() -> None:
    motion = JointMotion(LOWER, UPPER, SPEED, ACCELERATION)
    held = np.array((0.1, 0.0, 0.0))
    near = motion.near(np.array((0.3, 0.01, -0.5)), np.zeros(3), held)
    assert near == pytest.approx((0.1 + SLACK, 0.01, -SLACK))


def test_a_joint_that_is_beyond_its_limit_may_go_back_and_no_farther() -> None:
    follower = Follower(np.array((-0.001, 0.0, 0.0)))
    follower.tell(np.array((-0.05, 0.0, 0.0)))
    follower.run(REST_WITHIN)
    assert follower.state[0][0] == pytest.approx(-0.001, abs=1e-6)
    follower.tell(np.array((0.05, 0.0, 0.0)))
    follower.run(REST_WITHIN)
    assert follower.state[0][0] > 0.0
