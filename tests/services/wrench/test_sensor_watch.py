"""A stuck axis is told from a living one, and from a saturated one, in time and at every rate."""

from __future__ import annotations

import numpy as np
import pytest

from services.wrench.sensor_watch import SATURATED, STUCK, SensorWatch
from tests.services.wrench.sensor import NOISE

STUCK_AFTER = 0.1


class Stream:
    """A noisy sensor read every ``dt``; axes can be made to repeat their last value."""

    def __init__(self, dt: float, seed: int = 0) -> None:
        self.dt = dt
        self.watch = SensorWatch()
        self._random = np.random.default_rng(seed)
        self._last = np.zeros(6)

    def next(self, stuck: tuple[int, ...] = (), saturated: bool = False) -> str:
        reading = NOISE * self._random.standard_normal(6)
        reading[list(stuck)] = self._last[list(stuck)]
        self._last = reading
        return self.watch.update(reading, saturated, self.dt, STUCK_AFTER)


@pytest.mark.parametrize("rate", [30, 100, 250, 1000])
@pytest.mark.parametrize("axis", range(6))
def test_one_stuck_axis_is_reported_within_its_time(rate: int, axis: int) -> None:
    stream = Stream(1 / rate)
    for _ in range(50):
        assert stream.next() == ""
    repeats = 0
    while stream.next(stuck=(axis,)) == "":
        repeats += 1
        assert repeats < 1000
    assert (repeats + 1) / rate <= STUCK_AFTER + 1e-9
    assert (repeats + 1) / rate >= 0.6 * STUCK_AFTER, "a few repeated values are no proof"


def test_a_living_sensor_is_never_stuck() -> None:
    stream = Stream(0.01, seed=1)
    assert {stream.next() for _ in range(20_000)} == {""}


def test_a_coarse_sensor_that_repeats_by_chance_is_not_stuck() -> None:
    watch, random = SensorWatch(), np.random.default_rng(2)
    resolution = 0.2 * NOISE
    for _ in range(5_000):
        reading = resolution * np.round(5.0 * random.standard_normal(6))
        assert watch.update(reading, False, 0.01, STUCK_AFTER) == ""


def test_a_constant_source_is_stuck() -> None:
    watch = SensorWatch()
    reports = [watch.update(np.ones(6), False, 0.01, STUCK_AFTER) for _ in range(20)]
    assert reports[0] == "" and reports[-1] == STUCK


def test_one_gap_does_not_make_a_stuck_axis() -> None:
    stream = Stream(0.01)
    stream.next()
    stream.dt = 0.1
    assert stream.next(stuck=(0,)) == ""


def test_saturation_is_told_apart_at_once_and_ends_at_once() -> None:
    stream = Stream(0.01)
    stream.next()
    assert [stream.next(stuck=(2,), saturated=True) for _ in range(30)] == [SATURATED] * 30
    assert stream.next() == ""


def test_recovery_takes_as_long_again() -> None:
    stream = Stream(0.01)
    for _ in range(20):
        stream.next(stuck=(4,))
    reports = [stream.next() for _ in range(20)]
    assert reports[5] == STUCK and reports[-1] == ""
