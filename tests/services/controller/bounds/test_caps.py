"""Limits, errors and what they leave."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from services.controller.bounds.caps import Caps
from tests.services.controller.contacts import ERROR, LIMIT


def test_strict_caps_are_limit_less_error_and_reserve() -> None:
    caps = Caps(0.1, 1.0)
    caps.update(LIMIT, ERROR)
    W = LIMIT - ERROR
    assert caps.levels[0] == pytest.approx(np.tile(W, 2), rel=1e-2)
    assert np.all(caps.levels[0] <= np.tile(W, 2)), "an error bound is only ever widened"
    reserve = np.tile(np.maximum(0.1 * W, 3 * ERROR), 2)
    assert caps.levels[0] - caps.levels[2] == pytest.approx(reserve, rel=0.03)


def test_rounded_caps_keep_the_distance_within_one() -> None:
    rng = np.random.default_rng(0)
    caps = Caps(0.1, 0.8)
    caps.update(LIMIT, ERROR)
    start, room = np.array(caps.start), np.array(caps.room)
    for _ in range(300):
        h = rng.uniform(0, 0.6, 6) * rng.integers(0, 2, 6)
        cap = np.array(caps.rounded(h.tolist()))
        distance = np.linalg.norm((cap - start) / room)
        assert distance <= max(1.0, np.linalg.norm(h)) + 1e-12
        assert np.all(cap >= start + room * h - 1e-12)


@pytest.mark.parametrize("axis", range(6))
def test_limits_that_an_error_swallows_are_refused_by_name(axis: int) -> None:
    error = ERROR.copy()
    error[axis] = 0.34 * LIMIT[axis]
    caps = Caps(0.1, 1.0)
    caps.update(LIMIT, error)
    name = ("x", "y", "z", "about x", "about y", "about z")[axis]
    assert f"{name} is not above three times its error bound" in caps.refusal
    assert "tare" in caps.refusal
    caps.update(LIMIT, ERROR)
    assert caps.refusal is None


def test_small_changes_of_the_error_change_nothing_and_large_ones_do() -> None:
    caps = Caps(0.1, 1.0)
    caps.update(LIMIT, ERROR)
    before = caps.levels.copy()
    caps.update(LIMIT, ERROR * 1.01)
    assert np.array_equal(caps.levels, before)
    caps.update(LIMIT, ERROR * 1.1)
    assert np.all(caps.levels[0] < before[0])
    caps.update(LIMIT, ERROR)
    assert np.array_equal(caps.levels, before)


def lists(low: float, high: float, size: int = 6) -> st.SearchStrategy[list[float]]:
    return st.lists(st.floats(low, high), min_size=size, max_size=size)


@given(
    rho=st.sampled_from((1.0, 0.8, 0.5)),
    changes=st.lists(st.tuples(lists(0.05, 2.0), lists(0.0, 2.0), lists(-0.5, 0.5), lists(-1.5, 1.5, 12)), max_size=6),
)
def test_the_promise_falls_only_as_far_as_the_load_lets_it(
    rho: float, changes: Sequence[tuple[list[float], list[float], list[float], list[float]]]
) -> None:
    """Premises of "Changing limits" in docs/guarantee.md, for any limits, errors, nominal wrenches and loads."""
    caps, before = Caps(0.1, rho), np.full(6, np.inf)
    for scale, errors, shift, loads in changes:
        error, load = ERROR * errors, np.tile(LIMIT, 2) * loads
        limit = np.maximum(LIMIT * scale, 3.2 * error)
        caps.shift(LIMIT * shift)
        caps.update(limit, error)
        caps.lower(load)
        promise, most, wall, u = (
            np.array(caps.promise),
            np.array(caps.most),
            np.array(caps.wall),
            load.reshape((2, 6)).max(0),
        )
        kept = promise >= before + np.abs(LIMIT * shift) - 1e-9
        assert np.all(kept | (u <= most + 1e-9)), "a wall that falls leaves its rows open"
        assert np.all(promise <= np.maximum(limit, before + np.abs(LIMIT * shift)) + 1e-9)
        assert np.allclose(most + caps.errors, promise) and np.allclose(wall - caps.errors, promise)
        wished = Caps(0.1, rho)
        wished.update(limit, error)
        wished.lower(np.zeros(12))
        assert np.all(promise >= np.array(wished.promise) - 1e-9)
        if np.all(u <= wished.most):
            assert not caps.lowering, "nothing in the way: at once"
        before = promise


def test_an_error_that_grows_leaves_a_strict_limit_in_force_exactly() -> None:
    caps = Caps(0.1, 1.0)
    caps.update(LIMIT, ERROR)
    caps.lower(np.zeros(12))
    for factor in np.linspace(1.0, 2.0, 30):
        caps.update(LIMIT, factor * ERROR)
        assert not caps.lowering and caps.promise == LIMIT.tolist()
