"""The bound holds: for every error within the declared boxes, and for noise in all but a vanishing share of samples."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from services.wrench.averaging import Average
from services.wrench.compensation import Compensation, transport
from services.wrench.error_bound import error_bound, unknown_weight
from services.wrench.identification import identify
from shared.spatial import Array, rotation_from_vector
from tests.services.wrench.sensor import LEVEL, NOISE_BOUND, TILTED, TOOL_OFFSET, Sensor, external_wrench

BIAS_BOUND = np.array((3.0, 3.0, 3.0, 0.3, 0.3, 0.3))
vectors = st.tuples(*[st.floats(-3.0, 3.0)] * 3).map(np.array)
signs = st.tuples(*[st.sampled_from((-1.0, 1.0))] * 6).map(np.array)
inside = st.tuples(*[st.floats(-1.0, 1.0)] * 6).map(np.array)


def transported(box: Array, rotation: Array) -> Array:
    return np.abs(transport(rotation, TOOL_OFFSET)) @ box


def bound(compensation: Compensation, rotation: Array) -> Array:
    return error_bound(compensation, rotation, transport(rotation, TOOL_OFFSET), NOISE_BOUND, BIAS_BOUND, 0.83, 0.1)


@given(turn=vectors, signs=signs)
def test_transport_of_a_box_contains_its_corners_and_touches_one_per_axis(turn: np.ndarray, signs: np.ndarray) -> None:
    rotation, box = rotation_from_vector(turn), NOISE_BOUND
    limit = transported(box, rotation)
    assert np.all(np.abs(external_wrench(signs * box, Compensation(), rotation, TOOL_OFFSET)) <= limit + 1e-12)
    columns = np.array([external_wrench(unit, Compensation(), rotation, TOOL_OFFSET) for unit in np.diag(box)])
    worst = np.abs(columns).sum(axis=0)
    assert limit == pytest.approx(worst)


@given(field=vectors, lever=vectors)
def test_unknown_weight_covers_every_place_of_the_centre_of_mass(field: np.ndarray, lever: np.ndarray) -> None:
    lever = 0.1 * lever / max(1.0, float(np.linalg.norm(lever)))
    exact = np.concatenate((0.8 * field, np.cross(lever, 0.8 * field)))
    assert np.all(np.abs(exact) <= unknown_weight(0.8, 0.1, tuple(field)) + 1e-12)


@given(turn=vectors, bias=inside, noise=inside)
def test_untared_reading_is_within_its_bound(turn: np.ndarray, bias: np.ndarray, noise: np.ndarray) -> None:
    rotation = rotation_from_vector(turn)
    sensor = Sensor(bias=bias * BIAS_BOUND)
    reading = sensor.exact(rotation) + noise * NOISE_BOUND
    error = external_wrench(reading, Compensation(), rotation, TOOL_OFFSET)
    assert np.all(np.abs(error) <= bound(Compensation(), rotation) + 1e-9)


@given(tare=vectors, turn=vectors, noise=inside)
def test_tared_reading_is_within_its_bound_at_every_tilt(tare: np.ndarray, turn: np.ndarray, noise: np.ndarray) -> None:
    sensor, there, here = Sensor(), rotation_from_vector(tare), rotation_from_vector(turn)
    tared = Compensation().tared(sensor.exact(there), np.zeros(6), np.zeros(6), there)
    reading = sensor.exact(here) + noise * NOISE_BOUND
    error = external_wrench(reading, tared, here, TOOL_OFFSET)
    assert np.all(np.abs(error) <= bound(tared, here) + 1e-9)


def test_bound_after_a_tare_is_the_noise_where_it_was_made_and_the_weight_upside_down() -> None:
    tared = Compensation().tared(np.zeros(6), np.zeros(6), np.zeros(6), LEVEL)
    assert bound(tared, LEVEL) == pytest.approx(transported(NOISE_BOUND, LEVEL))
    over = rotation_from_vector((np.pi, 0.0, 0.0))
    weight = bound(tared, over) - transported(NOISE_BOUND, over)
    assert weight == pytest.approx([0, 0, 2 * 0.83 * 9.81, 2 * 0.083 * 9.81, 2 * 0.083 * 9.81, 0], abs=1e-9)


@pytest.mark.parametrize("kind", ["tare", "payload"])
def test_bound_holds_for_noisy_samples_and_is_not_idle(kind: str) -> None:
    sensor = Sensor(seed=3)
    if kind == "tare":
        average = sensor.average(LEVEL)
        known = Compensation().tared(average.mean, average.mean_error, average.noise, LEVEL)
        rotations = [rotation_from_vector((0.02, 0.01, 0.3 * n)) for n in range(20)]
    else:
        known = identify([sensor.average(rotation) for rotation in TILTED]).compensation()
        rotations = [rotation_from_vector((0.1 * n, -0.07 * n, 0.3 * n)) for n in range(20)]
    share = []
    for rotation in rotations:
        limit = bound(known, rotation)
        for _ in range(200):
            error = external_wrench(sensor.reading(rotation), known, rotation, TOOL_OFFSET)
            share.append(np.abs(error) / limit)
    largest = np.max(share, axis=0)
    assert np.all(largest < 1.0)
    assert np.all(largest > 0.2), "a bound five times too large would make the robot timid for nothing"


def test_a_noisier_sensor_than_declared_widens_the_bound() -> None:
    average = Average(np.zeros(6), 0.3 * np.ones(6), 100, LEVEL)
    noisy = Compensation().tared(average.mean, average.mean_error, average.noise, LEVEL)
    assert np.all(bound(noisy, LEVEL) >= 1.5)
