"""Motion relative to the base, and what it allows."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from services.experiment.carry.allowance import Certified
from services.experiment.carry.effort import effort
from services.experiment.carry.motion import Motion, spin
from shared.spatial import Array

TIME = np.arange(0.0, 4.0, 1 / 30)
IN_BASE = np.array((1.7, -0.4, 0.9))  # [m] the hands
TOOL = np.array((0.5, -0.4, 0.9))


def motion(base: Array, hand: Array, axes: Rotation) -> Motion:
    """Somebody who holds the panel at `hand` (n, 3) in base axes, its axes in base as given; the tool rests in base."""
    heading = Rotation.from_rotvec(np.outer(base[:, 2], (0.0, 0.0, 1.0)))
    planted = base[:, :2] @ np.eye(2, 3)
    count = len(TIME)
    return Motion(
        time=TIME,
        sampled=TIME,
        doing=np.full(count, "move"),
        panel=np.zeros((count, 3)),
        panel_axes=(heading * axes).as_matrix(),
        hand=planted + heading.apply(hand),
        wish=planted + heading.apply(hand),
        wish_axes=(heading * axes).as_matrix(),
        push=np.tile((2.0, 0.0, 0.0), (count, 1)),
        twist=np.tile((0.0, 0.0, 3.0), (count, 1)),
        base=base,
        tool=planted + heading.apply(np.tile(TOOL, (count, 1))),
        tool_axes=heading.as_matrix(),
    )


def test_who_walks_and_turns_with_the_base_does_not_move_in_it() -> None:
    base = np.column_stack((0.3 * TIME, np.sin(TIME), 0.4 * TIME))
    still = motion(base, np.tile(IN_BASE, (len(TIME), 1)), Rotation.identity(len(TIME)))
    assert np.abs(still.twist_in_base).max() < 2e-3


def test_turning_about_the_tool_moves_nothing_there_and_turning_about_the_hands_does() -> None:
    axes = Rotation.from_rotvec(np.outer(0.2 * TIME, (0.0, 0.0, 1.0)))
    inner = slice(5, -5)
    rest = np.zeros((len(TIME), 3))
    about_hands = motion(rest, np.tile(IN_BASE, (len(TIME), 1)), axes).twist_in_base[inner]
    assert about_hands == pytest.approx(
        np.tile((0.0, -0.24, 0.0, 0.0, 0.0, 0.2), (len(about_hands), 1)), abs=1e-3
    )
    about_tool = motion(rest, TOOL + axes.apply(IN_BASE - TOOL), axes).twist_in_base[inner]
    assert about_tool == pytest.approx(
        np.tile((0.0, 0.0, 0.0, 0.0, 0.0, 0.2), (len(about_tool), 1)), abs=1e-3
    )


def test_spin_is_the_angular_velocity_in_world() -> None:
    start = Rotation.from_euler("xyz", (0.3, -0.5, 1.0))
    axes = (Rotation.from_rotvec(np.outer(TIME, (0.1, -0.2, 0.3))) * start).as_matrix()
    assert spin(TIME, axes)[20] == pytest.approx((0.1, -0.2, 0.3), abs=1e-3)


def test_work_is_force_times_way_and_torque_times_angle() -> None:
    axes = Rotation.from_rotvec(np.outer(0.1 * TIME, (0.0, 0.0, 1.0)))
    found = effort(
        motion(np.zeros((len(TIME), 3)), IN_BASE + np.outer(0.2 * TIME, (1.0, 0.0, 0.0)), axes),
        -1.0,
        9.0,
    )
    lasts = TIME[-1] + 1 / 30
    assert found.work == pytest.approx((2.0 * 0.2 + 3.0 * 0.1) * lasts, rel=1e-2)
    assert found.lifting == pytest.approx(0.0, abs=1e-9)
    assert found.guiding == pytest.approx(found.work, rel=1e-9)
    assert (found.force, found.torque) == (2.0, 3.0)


def test_what_motion_allows_is_what_certify_states() -> None:
    settings = {"yield_start": 0.8, "contact_stiffness": 500.0, "contact_reach": [1.2, 0.05, 0.3]}
    limit, error = (10.0, 10.0, 10.0, 0.5, 3.0, 3.0), (0.6, 0.6, 0.6, 0.03, 0.1, 0.1)
    quarter = Rotation.from_rotvec([(0.0, 0.0, 0.0), (np.pi / 2, 0.0, 0.0)]).as_quat()
    found = Certified.of(settings, np.array(limit), np.array(error), quarter)
    assert found.stiffness.shape == (2, 6, 6)
    # Turned by 90 degrees, y and z change places.
    swap = np.array((0, 2, 1, 3, 5, 4))
    assert found.stiffness[1] == pytest.approx(found.stiffness[0][np.ix_(swap, swap)])
    speed = 0.1
    twist = np.array([(speed, 0.0, 0.0, 0.0, 0.0, 0.0)])
    expected = 3.0 * found.stiffness[0][:, 0] * speed * (found.response + speed / (2 * 2.0))
    assert found.excess(twist, np.array([0]))[0] == pytest.approx(expected)
    assert np.all(found.excess(2 * twist, np.array([0])) > 2 * found.excess(twist, np.array([0])))


def test_a_configuration_without_a_certificate_is_refused_with_the_reason() -> None:
    with pytest.raises(ValueError, match="yield_start"):
        Certified.of({"yield_start": 7.0}, np.full(6, 10.0), np.full(6, 0.1), np.zeros((0, 4)))
