"""Limits, errors and what they leave."""

from __future__ import annotations

import numpy as np
import pytest

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
