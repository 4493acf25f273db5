"""Averages of a tool at rest, and the refusal of anything else."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from services.wrench.averaging import Average, AveragingWindow, NotStill
from shared.spatial import Array, rotation_from_vector, rotation_vector
from tests.services.wrench.sensor import LEVEL, NOISE, NOISE_BOUND, Sensor

DT = 0.01
BIAS_BOUND = 10 * NOISE_BOUND


def averaged(readings: list[Array], rotations: list[Array] | None = None, duration: float | None = None) -> Average:
    window = AveragingWindow(duration or DT * (len(readings) - 1) - 1e-9, NOISE_BOUND, np.zeros(6), BIAS_BOUND)
    full = [window.add(r, R, DT) for r, R in zip(readings, rotations or [LEVEL] * len(readings), strict=True)]
    assert full == [False] * (len(full) - 1) + [True]
    return window.average()


def test_mean_and_deviation() -> None:
    sensor = Sensor()
    average = averaged([sensor.reading(LEVEL) for _ in range(400)])
    assert np.all(np.abs(average.mean - sensor.exact(LEVEL)) <= average.mean_error)
    assert average.std == pytest.approx(NOISE, rel=0.2)
    assert average.samples == 400


def test_bound_on_the_mean_holds() -> None:
    sensor = Sensor(seed=7)
    for _ in range(50):
        average = averaged([sensor.reading(LEVEL) for _ in range(40)])
        assert np.all(np.abs(average.mean - sensor.exact(LEVEL)) <= average.mean_error)


def test_spikes_steps_and_dead_zones_are_in_the_bounds() -> None:
    sensor = Sensor()
    readings = np.array([sensor.reading(LEVEL) for _ in range(200)])
    spiky = readings.copy()
    spiky[::40] += 12 * NOISE
    assert np.all(averaged(list(spiky)).noise >= 10 * NOISE)
    step = 10 * NOISE
    coarse = averaged(list(step * np.round(readings / step)))
    assert np.all(np.abs(coarse.mean - sensor.exact(LEVEL)) <= np.maximum(coarse.mean_error, 0.51 * step))
    dead = readings * (1, 1, 0, 1, 1, 0)
    dead[:, 1] = np.where(np.abs(dead[:, 1] + 2.0) < 0.15, 0.0, dead[:, 1] + 2.0)
    error = averaged(list(dead)).mean_error
    assert error[1] > 0.15 and error[2] == BIAS_BOUND[2] and error[0] < 0.1
    assert not averaged([np.zeros(6)] * 100).noise.any(), "no noise at all is no dead zone"
    window = AveragingWindow(1.0, NOISE_BOUND, step, BIAS_BOUND)
    for _ in range(10):
        window.add(np.zeros(6), LEVEL, DT)
    assert window.average().mean_error == pytest.approx(step)


def pushed(n: int) -> Array:
    return np.array((0, 0, 0.01 * n, 0, 0, 0))


def swung(n: int) -> Array:
    return np.array((0, 4 * np.sin(0.3 * n), 0, 0, 0, 0))


NOT_STILL: dict[str, tuple[int, Callable[[int], Array], float, str]] = {
    "too short": (5, lambda n: np.zeros(6), 0.0, "only 5 samples"),
    "swinging": (100, swung, 0.0, "force y varies"),
    "slowly pushed": (100, pushed, 0.0, "force z drifts"),
    "turning": (100, lambda n: np.zeros(6), 0.0003, r"turned by 0\.030 rad"),
}


@pytest.mark.parametrize("name", NOT_STILL)
def test_what_is_no_tool_at_rest_is_refused(name: str) -> None:
    count, force, turn, words = NOT_STILL[name]
    sensor = Sensor()
    rotations = [rotation_from_vector((0.0, turn * n, 0.0)) for n in range(count)]
    with pytest.raises(NotStill, match=words):
        averaged([sensor.reading(rotation) + force(n) for n, rotation in enumerate(rotations)], rotations)


def test_orientation_is_averaged_too() -> None:
    sensor = Sensor()
    rotations = [rotation_from_vector((0.0, 0.004 * (n % 2), 0.0)) for n in range(100)]
    average = averaged([sensor.reading(LEVEL) for _ in rotations], rotations)
    assert rotation_vector(average.rotation) == pytest.approx([0.0, 0.002, 0.0], abs=1e-6)


@pytest.mark.parametrize("share", [0.0, 0.8, 0.9])
def test_readings_behind_a_low_pass_are_worth_fewer(share: float) -> None:
    """The bound on the mean's error holds for readings that resemble each other."""
    rng = np.random.default_rng(3)
    errors, bounds = [], []
    for _ in range(200):
        window = AveragingWindow(1.0, np.full(6, 5.0), np.zeros(6), np.zeros(6))
        state = rng.standard_normal(6)
        for _ in range(101):
            state = share * state + math.sqrt(1.0 - share**2) * rng.standard_normal(6)
            window.add(state, np.eye(3), 0.01)
        try:
            average = window.average()
        except NotStill:
            continue
        errors.append(abs(average.mean))
        bounds.append(average.mean_error)
    assert len(errors) > 100
    ratio = np.array(errors) / np.array(bounds)
    assert np.sqrt((ratio**2).mean()) < 1.6 / 5.0  # one standard deviation of five, known by 100 readings


def test_how_coarse_an_axis_is_that_repeats_one_value_has_to_be_declared() -> None:
    """A simulator without noise, or a sensor with steps of newtons: rounding of the mean must not decide which."""
    reading = np.array((0.3, -0.7, -8.07, 0.05, 0.1, 0.02))
    made = averaged([reading] * 51)
    assert np.allclose(made.mean_error, BIAS_BOUND) and made.noise.max() < 1e-9
    window = AveragingWindow(0.5, NOISE_BOUND, np.full(6, 1e-6), BIAS_BOUND)
    while not window.add(reading, LEVEL, DT):
        pass
    assert window.average().mean_error.max() < 1.1e-6


@pytest.mark.parametrize("load", [0.0, 0.7, 0.95, 1.05])
@pytest.mark.parametrize("centre", [0.0, -3.7])
def test_a_dead_zone_that_shows_is_in_the_bound_of_the_mean(load: float, centre: float) -> None:
    zone, sensor = 8.0 * NOISE, np.random.default_rng(2)
    inside = load * zone + NOISE * sensor.standard_normal((200, 6))
    inside[0] = 1.2 * zone
    average = averaged(list(centre + np.where(np.abs(inside) < zone, 0.0, inside)))
    assert np.all(np.abs(average.mean - centre - load * zone) <= average.mean_error)


def test_digits_finer_than_the_noise_are_no_dead_zone() -> None:
    readings = np.round(NOISE * np.random.default_rng(4).standard_normal((100, 6)) * 500.0) / 500.0
    assert not averaged(list(readings)).rounding[:3].any()
