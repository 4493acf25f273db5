"""The wrench carried over to the base's origin, against the general transport, and its dead band."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from services.base.planar_wrench import about_base, beyond_dead_band, error_about_base
from shared.spatial import wrench_about

numbers = st.floats(-100, 100)
vectors = st.tuples(numbers, numbers, numbers)
errors = st.tuples(*[st.floats(0, 10)] * 6)


def test_a_lateral_force_in_front_turns_to_its_side() -> None:
    assert about_base((0.0, 10.0, 0.0), (0.0, 0.0, 0.0), (0.6, 0.0, 1.0)) == (0.0, 10.0, 6.0)
    assert about_base((10.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.6, -0.2, 1.0)) == (10.0, 0.0, 3.0)
    assert about_base((0.0, 0.0, -15.0), (5.0, 7.0, 0.0), (0.6, -0.2, 1.0)) == (0.0, 0.0, 0.0)


@given(vectors, vectors, vectors)
def test_the_moment_is_that_of_the_general_transport(force, torque, position) -> None:
    moved = wrench_about(np.array((*force, *torque)), position)
    assert about_base(force, torque, position) == pytest.approx((moved[0], moved[1], moved[5]))


@given(vectors, vectors, vectors, errors, st.lists(st.floats(-1, 1), min_size=6, max_size=6))
def test_no_error_within_the_bound_at_the_tool_is_beyond_the_bound_at_the_base(
    force, torque, position, bound, shares
) -> None:
    off = np.multiply(bound, shares)
    true = about_base(force, torque, position)
    felt = about_base(np.add(force, off[:3]), np.add(torque, off[3:]), position)
    assert np.all(np.abs(np.subtract(felt, true)) <= np.add(error_about_base(bound, position), 1e-9))


def test_the_bound_about_the_base_is_attained() -> None:
    bound, position = (0.2, 0.3, 0.9, 0.8, 0.7, 0.05), (0.6, -0.2, 1.0)
    assert error_about_base(bound, position) == pytest.approx((0.2, 0.3, 0.05 + 0.6 * 0.3 + 0.2 * 0.2))
    assert about_base((0.2, 0.3, 0.0), (0, 0, 0.05), position)[2] == pytest.approx(0.05 + 0.18 + 0.04)


@given(vectors, st.tuples(*[st.floats(0, 50)] * 3))
def test_the_dead_band_takes_its_width_and_no_more(wrench, band) -> None:
    for left, element, half in zip(beyond_dead_band(wrench, band), wrench, band, strict=True):
        assert left * element >= 0.0
        assert abs(left) == pytest.approx(max(0.0, abs(element) - half))
