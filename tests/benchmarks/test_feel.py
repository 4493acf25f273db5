"""The figures of what carrying feels like: smoothness as it is defined, and forces that work against each other."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.feel import _longest, log_dimensionless_jerk, opposing
from shared.spatial import Array

STEP = 1.0 / 30.0
MINIMUM_JERK = -math.log(204.8)  # 720 / 1.875^2


def least_jerk(duration: float, way: Array) -> tuple[Array, Array]:
    """Times (n,) [s] and places (n, 3) [m] of the movement of least jerk that begins and ends at rest."""
    time = np.arange(0.0, duration + STEP / 2.0, STEP)
    part = np.minimum(time / duration, 1.0)
    return time, np.outer(10 * part**3 - 15 * part**4 + 6 * part**5, way)


@given(st.floats(2.0, 10.0), st.floats(0.01, 1.0), st.floats(0.0, 6.28))
def test_of_the_movement_of_least_jerk_it_is_known_whatever_way_and_time(size: float, way: float, angle: float) -> None:
    time, path = least_jerk(size, way * np.array((np.cos(angle), np.sin(angle), 0.3)))
    assert log_dimensionless_jerk(time, path) == pytest.approx(MINIMUM_JERK, abs=0.25)


def test_the_more_pieces_a_movement_falls_into_the_less_smooth_it_is() -> None:
    found = []
    for pieces in (1, 2, 4):
        _, part = least_jerk(8.0 / pieces, np.array((0.4 / pieces, 0.0, 0.0)))
        path = np.concatenate([part + number * part[-1] for number in range(pieces)])
        found.append(log_dimensionless_jerk(STEP * np.arange(len(path)), path))
    assert found[0] > found[1] + 1.0 and found[1] > found[2] + 1.0


def test_what_does_not_move_has_no_smoothness() -> None:
    time = np.arange(0.0, 2.0, STEP)
    assert np.isnan(log_dimensionless_jerk(time, np.zeros((len(time), 3))))


def test_forces_work_against_each_other_by_the_smaller_of_two_that_oppose() -> None:
    hands, robot = np.array((3.0, 3.0, -2.0, 0.0)), np.array((-1.0, 2.0, 5.0, -4.0))
    assert opposing(hands, robot).tolist() == [1.0, 0.0, 2.0, 0.0]
    assert opposing(robot, hands).tolist() == [1.0, 0.0, 2.0, 0.0]


def test_the_longest_stretch_is_one_without_a_break() -> None:
    time = 0.1 * np.arange(8)
    assert _longest(time, np.array((1, 0, 1, 1, 1, 0, 1, 1), dtype=bool)) == pytest.approx(0.2)
    assert _longest(time, np.zeros(8, dtype=bool)) == 0.0
