"""The speed box: speeding up is limited in tool axes, slowing down never, and the gate never has to clamp."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from services.controller.laws.speed_box import SpeedBox, rotated_limits
from services.controller.parameters import ControllerParameters
from shared.spatial import rotation_from_vector

vectors = st.tuples(*(st.floats(-3, 3),) * 3)
limits = st.tuples(*(st.floats(0.1, 10),) * 3)


@given(turn=vectors, limit=limits)
def test_box_in_base_axes_lies_within_the_tools(turn: tuple, limit: tuple) -> None:
    rotation = rotation_from_vector(turn)
    box = np.array(rotated_limits(rotation, limit))
    corners = np.array(list(itertools.product((-1, 1), repeat=3))) * box
    assert np.all(np.abs(corners @ rotation) <= np.array(limit) * (1 + 1e-9))
    assert np.all(box > 0)


def test_box_is_exact_for_parallel_axes_and_loses_at_most_sqrt_3() -> None:
    assert rotated_limits(np.eye(3), (1.0, 2.0, 3.0)) == pytest.approx([1.0, 2.0, 3.0])
    swapped = np.array(((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
    assert rotated_limits(swapped, (1.0, 2.0, 3.0)) == pytest.approx([2.0, 1.0, 3.0])
    rng = np.random.default_rng(0)
    for _ in range(200):
        box = rotated_limits(rotation_from_vector(rng.normal(size=3)), (1.0, 1.0, 1.0))
        assert min(box) > 1.0 / 3.0 and np.linalg.norm(box) > 0.99


def box_after(speeds: np.ndarray, dt: float = 0.01, **changes: object) -> SpeedBox:
    box = SpeedBox(ControllerParameters.of({"max_acceleration": (2.0,) * 3 + (4.0,) * 3, **changes}))
    box.update(np.eye(3), speeds, dt)
    return box


def test_speeding_up_is_limited_and_slowing_down_is_not() -> None:
    moving = np.zeros(12)
    moving[6] = 0.1  # along +x
    box = box_after(moving)
    gain = pytest.approx(0.02, rel=0.05)
    assert box.reach[6] - 0.1 == gain
    assert box.reach[0] == gain, "back through zero, and as much beyond it as from standing"
    assert box.reach[9:] == pytest.approx(np.full(3, 0.04), rel=0.05)
    assert np.all(box.reach >= 0.0)


RETREAT = (5.0, 1.0, 5.0, 8.0, 8.0, 8.0)


def test_what_gives_way_speeds_up_faster_but_never_slower_than_declared_for_the_rest() -> None:
    box = box_after(np.zeros(12), max_retreat_acceleration=RETREAT)
    assert box.retreat_reach(np.zeros(12), 0.01)[6:] == pytest.approx([0.05, 0.02, 0.05, 0.08, 0.08, 0.08], rel=0.1)
    assert np.all(box.retreat_reach(np.full(12, 0.24), 0.01)[:3] <= 0.25)


def test_what_gives_way_with_a_payload_moves_it_no_faster() -> None:
    box = box_after(np.zeros(12), max_retreat_acceleration=RETREAT, payload_mass=1.0)
    assert box.retreat_reach(np.zeros(12), 0.01) == pytest.approx(box.reach)


@given(turn=vectors, ahead=vectors)
def test_the_box_of_what_gives_way_lies_within_the_tools_too(turn: tuple, ahead: tuple) -> None:
    box = SpeedBox(ControllerParameters.of({"max_retreat_acceleration": RETREAT}))
    box.update(rotation_from_vector(turn), np.zeros(12), 0.01)
    nearby = rotation_from_vector(np.array(turn) + 1e-4 * np.array(ahead))
    box.update(nearby, np.zeros(12), 0.01)
    corners = np.array(list(itertools.product((-1, 1), repeat=3))) * box.retreat_reach(np.zeros(12), 0.01)[:3]
    assert np.all(np.abs(corners @ nearby) <= 0.01 * np.maximum(RETREAT[:3], 2.0) * (1 + 1e-9))


def test_box_never_exceeds_the_speed_limits() -> None:
    box = box_after(np.full(12, 0.24), dt=0.02)
    assert np.all(box.reach[:3] <= 0.25) and np.all(box.reach[3:6] <= 0.5)


def test_a_longer_interval_than_the_period_gains_no_more() -> None:
    assert box_after(np.zeros(12), dt=5.0).reach[0] == pytest.approx(box_after(np.zeros(12), dt=0.02).reach[0])


@given(twist=st.tuples(*(st.floats(-1, 1),) * 6))
def test_shortened_twist_keeps_its_direction_and_both_norms(twist: tuple) -> None:
    box = box_after(np.zeros(12))
    given_twist = np.array(twist)
    result = box.shortened(given_twist)
    assert result is not None
    assert np.linalg.norm(result[:3]) <= 0.25 * (1 + 1e-12)
    assert np.linalg.norm(result[3:]) <= 0.5 * (1 + 1e-12)
    scale = float(result @ given_twist) / max(float(given_twist @ given_twist), 1e-300)
    assert result == pytest.approx(scale * given_twist, abs=1e-12)
    assert scale <= 1 + 1e-12


def test_payload_inertia_is_counted_in_base_axes() -> None:
    box = box_after(np.zeros(12), payload_mass=1.5)
    assert np.all(box.inertial_force[:3] >= 1.5 * 2.0) and np.all(box.inertial_force[:3] <= 1.5 * 2.1)
    assert not box.inertial_force[3:].any()
