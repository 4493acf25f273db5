"""A stuck axis is told from a living one, a saturated one and one that repeats values in health, at every rate."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from services.wrench.sensor_watch import INVALID, SATURATED, STUCK, SensorWatch
from shared.spatial import Array
from tests.services.wrench.sensor import NOISE

STUCK_AFTER = 0.1
LIVED = 50  # readings


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
    for _ in range(LIVED):
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


def reports(readings: Iterator[Array] | list[Array], rate: float = 100.0, **declared: tuple[float, ...]) -> list[str]:
    watch = SensorWatch()
    return [watch.update(reading, False, 1 / rate, STUCK_AFTER, **declared) for reading in readings]


def noisy(count: int, seed: int = 0) -> Array:
    return NOISE * np.random.default_rng(seed).standard_normal((count, 6))


@given(share=st.floats(0.01, 0.5), rate=st.sampled_from([30.0, 100.0, 500.0]), seed=st.integers(0, 99))
@settings(max_examples=20, deadline=None)
def test_steps_up_to_half_the_noise_are_never_stuck(share: float, rate: float, seed: int) -> None:
    step = share * NOISE
    assert set(reports(step * np.round(noisy(1_000, seed) / step), rate)) == {""}


@given(share=st.floats(1.0, 8.0), offset=st.floats(0.0, 1.0), seed=st.integers(0, 99))
@settings(max_examples=20, deadline=None)
def test_coarser_steps_are_not_stuck_either_declared_or_not(share: float, offset: float, seed: int) -> None:
    step = share * NOISE
    within = np.repeat((offset, 0.5 - offset), 500)[:, None]  # another load then, elsewhere within a step
    readings = step * np.round(noisy(1_000, seed) / step + within)
    assert set(reports(readings)) == {""}
    assert set(reports(readings, resolution=tuple(step))) == {""}


def ideal(time: float) -> Array:
    """A simulator without noise: rest, a push that comes and goes, rest, at an axis that is always exactly zero."""
    push = math.sin(math.pi * (time - 1.0)) ** 2 if 1.0 < time < 3.0 else 0.0
    return push * np.array((0.0, 10.0, -20.0, 1.0, 0.5, 0.0)) + (0, 0, -8.0, 0, 0, 0)


def dead(readings: Array) -> Array:
    return np.where(np.abs(readings) < 4 * NOISE, 0.0, readings)


ramps = np.concatenate((np.zeros(300), np.linspace(0, 10, 200), np.linspace(10, 0, 200), np.zeros(300)))[:, None]
SOUND: dict[str, Callable[[], Array]] = {
    "without noise": lambda: np.array([ideal(0.01 * n) for n in range(500)]),
    "constant": lambda: np.ones((100, 6)),
    "one axis always zero": lambda: noisy(500) * (0, 1, 1, 1, 1, 1),
    "dead zone": lambda: dead(noisy(1_000) + ramps * (1, 1, 1, 0.05, 0.05, 0.05)),
}


@pytest.mark.parametrize("name", SOUND)
def test_what_repeats_values_in_health_is_not_stuck(name: str) -> None:
    assert set(reports(SOUND[name]())) == {""}


@pytest.mark.parametrize("share", [0.0, 0.3])
def test_a_coarse_axis_that_freezes_is_found_a_little_later(share: float) -> None:
    readings = noisy(600)
    step = share * NOISE
    if share:
        readings = step * np.round(readings / step)
    readings[500:, 3] = readings[500, 3]
    words = reports(readings)
    onset = words.index(STUCK)
    assert 500 < onset <= (508 if not share else 515)


def test_all_axes_at_once_are_another_cause_than_one() -> None:
    said = []
    for axes in ([4], list(range(6))):
        watch = SensorWatch()
        readings = noisy(80)
        readings[60:, axes] = readings[59, axes]
        for reading in readings:
            word = watch.update(reading, False, 0.01, STUCK_AFTER)
        assert word == STUCK
        said.append(watch.reason)
    assert "torque y" in said[0] and "cable" in said[0] and "all axes" in said[1] and "repeat an old" in said[1]
    assert all("resolution" in text for text in said)


def test_a_reading_that_does_not_follow_the_identified_weight_is_stuck_without_any_noise() -> None:
    def turned(angle: float, frozen: bool) -> str:
        watch = SensorWatch()
        for share in np.linspace(0.0, 1.0, 50):
            weight = 8.0 * np.array((math.sin(share * angle), 0, -math.cos(share * angle), 0, 0, 0))
            reading = np.array((0.0, 0, -8.0, 0, 0, 0)) if frozen else weight
            word = watch.update(reading, False, 0.01, STUCK_AFTER, weight=weight, known=True)
        return word

    assert turned(0.3, frozen=True) == STUCK
    assert turned(0.3, frozen=False) == turned(0.03, frozen=True) == ""


def test_a_chance_repeat_of_a_coarse_axis_while_the_weight_changes_is_no_fault() -> None:
    watch, step = SensorWatch(), NOISE
    readings = step * np.round(noisy(400) / step)
    for number, reading in enumerate(readings):
        weight = np.full(6, 8.0 * math.sin(0.1 * number))
        assert watch.update(reading, False, 0.01, STUCK_AFTER, weight=weight, known=True) == ""


def test_an_axis_that_never_changed_is_spoken_of() -> None:
    watch = SensorWatch()
    for reading in noisy(300) * (0, 1, 1, 1, 1, 1):
        watch.update(reading, False, 0.01, STUCK_AFTER)
    assert watch.notes().startswith("force x at 0 N has not changed since the start: a sensor of fewer axes")
    watch.update(np.ones(6), False, 0.01, STUCK_AFTER)
    assert watch.notes() == ""


def test_an_axis_that_freezes_farther_out_than_ever_is_saturated() -> None:
    readings = noisy(400)
    readings[200:, 2] += np.minimum(np.arange(200) * 2.0, 300.0)
    readings[:, 2] = np.minimum(readings[:, 2], 250.0)
    assert set(reports(readings)) == {"", SATURATED}
    assert set(reports(readings, sensor_range=(250.0,) * 6)[330:]) == {SATURATED}
    assert set(reports(readings, sensor_range=(249.0,) * 6)[330:]) == {INVALID}


@pytest.mark.parametrize(("end", "word"), [(250.0, SATURATED), (-40.0, SATURATED), (0.0, STUCK), (3.0, STUCK)])
def test_an_axis_that_leaps_far_out_is_saturated_and_one_that_leaps_elsewhere_stuck(end: float, word: str) -> None:
    readings = noisy(400) + np.array((0, 0, -8.0, 0, 0, 0))
    readings[300:, 2] = end
    assert set(reports(readings, sensor_range=(400.0,) * 6)) == {"", word}


def pushes(count: int) -> Array:
    """Pushes that come and go within a sample, with rest between them: their size (n, 1)."""
    return np.where(np.arange(count) % 80 < 60, 20.0, 0.0)[:, None]


@dataclass
class Zoned:
    """A dead zone of some width on some axes, about a value of its own; at rest, pushed, and at rest for 10 s."""

    width: float = 10.0  # times the noise
    axes: tuple[int, ...] = (0, 3)
    centre: float = 0.0
    seed: int = 0
    rest: int = 1000
    before: int = 100

    @property
    def readings(self) -> Array:
        load = np.concatenate((np.zeros((self.before, 1)), pushes(320), np.zeros((self.rest, 1))))
        readings = noisy(len(load), self.seed) + load * (1, -1, 1, 0.05, 0.05, -0.05) + self.centre
        axes = list(self.axes)
        inside = np.abs(readings[:, axes] - self.centre) < self.width * NOISE[axes]
        readings[:, axes] = np.where(inside, self.centre, readings[:, axes])
        return readings


@given(
    zone=st.builds(
        Zoned,
        width=st.floats(0.3, 150.0),
        axes=st.sampled_from([(0,), (2,), (3,), (1, 4), tuple(range(6))]),
        centre=st.sampled_from([0.0, -3.7]),
        seed=st.integers(0, 99),
    )
)
@settings(max_examples=30, deadline=None)
def test_an_axis_that_is_back_in_the_dead_zone_it_began_in_is_not_stuck(zone: Zoned) -> None:
    assert set(reports(zone.readings)) == {""}


def test_a_dead_zone_that_has_shown_is_told_with_its_width_and_one_that_is_declared_is_not() -> None:
    watch, declared = SensorWatch(), SensorWatch()
    step = tuple(20.0 * NOISE)
    zone = Zoned(centre=-3.7)
    for number, reading in enumerate(zone.readings):
        watch.update(reading, False, 0.01, STUCK_AFTER)
        declared.update(reading, False, 0.01, STUCK_AFTER, resolution=step)
        if number < zone.before + 60:
            assert not watch.zones.any(), "not before it has come back"
    assert np.all(watch.zones[[0, 3]] >= 10.0 * NOISE[[0, 3]]) and np.count_nonzero(watch.zones) == 2
    assert "force x is at -3.7 N or at least" in watch.notes() and "`resolution`" in watch.notes()
    assert not declared.zones.any() and declared.notes() == ""


def test_an_axis_that_freezes_outside_its_dead_zone_is_found_in_time_however_long_it_rested() -> None:
    readings = np.concatenate((Zoned(before=6000, rest=6000).readings, noisy(100, 7) + 15.0))
    readings[-20:, 0] = readings[-21, 0]
    words = reports(readings)
    assert set(words[:-20]) == {""} and words.index(STUCK) - (len(words) - 20) < 10


def test_a_cable_that_loses_contact_again_and_again_is_stuck_and_no_dead_zone() -> None:
    readings = noisy(1_000) + np.array((0, 0, -2.0, 0, 0, 0))
    for number, dropped in enumerate(range(100, 1_000, 100)):
        readings[dropped : dropped + 2 + 5 * number, 2] = 0.0
    words = reports(readings)
    assert set(words[:301]) == {""} and all(STUCK in words[start : start + 60] for start in range(400, 1_000, 100))


def test_an_axis_that_freezes_in_its_dead_zone_is_found_when_more_weight_turns_than_the_zone_hides() -> None:
    def turned(change: float) -> str:
        watch = SensorWatch()
        for number, reading in enumerate(Zoned(width=10.0).readings):
            weight = np.full(6, change if number > 1_200 else 0.0)
            word = watch.update(reading, False, 0.01, STUCK_AFTER, weight=weight, known=True)
        return word

    assert turned(1.9) == "" and turned(30.0) == STUCK


@pytest.mark.parametrize("share", [1.0, 2.0, 4.0])
def test_coarse_steps_at_rest_after_pushes_are_not_stuck(share: float) -> None:
    step = share * NOISE
    readings = step * np.round((noisy(1_500) + np.concatenate((pushes(480), np.zeros((1_020, 1))))) / step)
    assert set(reports(readings)) == {""}


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
    for _ in range(LIVED):
        stream.next()
    for _ in range(20):
        stream.next(stuck=(4,))
    words = [stream.next() for _ in range(20)]
    assert words[5] == STUCK and words[-1] == ""
