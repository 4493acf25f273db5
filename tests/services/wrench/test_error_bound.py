"""The bound holds: for every error within the declared boxes, and for noise in all but a vanishing share of samples."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from services.wrench.averaging import Average
from services.wrench.compensation import Compensation, transport, upright
from services.wrench.error_bound import NO_ZERO, bias_error, error_bound, unknown_weight
from services.wrench.identification import identify
from shared.spatial import Array, rotation_from_vector
from tests.services.wrench.sensor import DOWN, LEVEL, NOISE_BOUND, TILTED, TOOL_OFFSET, Sensor, external_wrench

BIAS_BOUND = np.array((5.0, 5.0, 5.0, 0.5, 0.5, 0.5))
vectors = st.tuples(*[st.floats(-3.0, 3.0)] * 3).map(np.array)
signs = st.tuples(*[st.sampled_from((-1.0, 1.0))] * 6).map(np.array)
inside = st.tuples(*[st.floats(-1.0, 1.0)] * 6).map(np.array)


def transported(box: Array, rotation: Array) -> Array:
    return np.abs(transport(rotation, TOOL_OFFSET)) @ box


def bound(
    compensation: Compensation,
    rotation: Array,
    age: float | None = None,
    drift: Array | float = 0.0,
    gravity: Array = DOWN,
    tilt: float = 0.0,
) -> Array:
    age = (NO_ZERO if compensation.kind == "none" else 0.0) if age is None else age
    box = np.maximum(NOISE_BOUND, compensation.noise)
    box = box + bias_error(compensation, age, np.broadcast_to(drift, 6), BIAS_BOUND)
    to_tool = transport(rotation, TOOL_OFFSET)
    return error_bound(compensation, rotation, to_tool, box, (0.83, 0.1), gravity, tilt)


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


def off_by(tilt: float, turn: Array, direction: Array) -> Array:
    """A direction turned by a tilt at most."""
    return rotation_from_vector(tilt * turn / max(1.0, float(np.linalg.norm(turn)))) @ direction


@given(
    kind=st.sampled_from(("none", "tare", "payload", "file")),
    turns=st.tuples(vectors, vectors),
    told=st.tuples(vectors, vectors),
    off=st.tuples(vectors, vectors),
    bias=inside,
    drift=inside,
    noise=inside,
    minutes=st.floats(0.0, 100.0),
    tilt=st.floats(0.0, 0.2),
)
def test_a_zero_of_any_age_on_any_ramp_is_within_its_bound(kind, turns, told, off, bias, drift, noise, minutes, tilt):
    # In turns: where the zero was measured, and now. The robot may tell any direction; gravity is off by the tilt.
    directions = [rotation_from_vector(0.3 * turn) @ DOWN for turn in told]
    truly = [off_by(tilt, turn, direction) for turn, direction in zip(off, directions, strict=True)]
    there, here = (rotation_from_vector(turn) for turn in turns)
    sensor = Sensor(bias=bias * BIAS_BOUND, gravity=truly[0])
    known = Compensation()
    if kind in ("payload", "file"):
        guess = sensor.bias + drift * BIAS_BOUND
        known = Compensation("payload", bias=guess, mass=sensor.mass, moment=sensor.mass * sensor.com)
    if kind in ("payload", "tare"):
        zeros = np.zeros(6)
        known = known.tared(sensor.exact(there), zeros, zeros, upright(there, directions[0]))
    age, speed = (60.0 * minutes, 0.02 * BIAS_BOUND) if kind in ("payload", "tare") else (NO_ZERO, 0.0)
    if age > 0.0:
        sensor.bias = sensor.bias + np.clip(minutes * speed, None, BIAS_BOUND) * drift
    sensor.gravity = truly[1]
    reading = sensor.exact(here) + noise * NOISE_BOUND
    error = transport(here, TOOL_OFFSET) @ (reading - known.offset(upright(here, directions[1])))
    assert np.all(np.abs(error) <= bound(known, here, age, speed, directions[1], tilt) + 1e-9)


@given(turns=st.tuples(*[vectors] * 4), told=vectors, off=vectors, place=vectors, tilt=st.floats(0.0, 0.1))
def test_a_payload_that_was_identified_on_a_ramp_is_within_its_bound_elsewhere(turns, told, off, place, tilt) -> None:
    direction = rotation_from_vector(0.3 * told) @ DOWN
    sensor = Sensor(gravity=off_by(tilt, off, direction))
    poses = [*TILTED, *map(rotation_from_vector, turns)]
    averages = [Average(sensor.exact(R), 0.1 * NOISE_BOUND, 100, upright(R, direction)) for R in poses]
    known = identify(averages).compensation()
    sensor.gravity = off_by(tilt, place, direction)
    for here in map(rotation_from_vector, turns):
        error = transport(here, TOOL_OFFSET) @ (sensor.exact(here) - known.offset(upright(here, direction)))
        without_noise = bound(known, here, gravity=direction, tilt=tilt) - transported(NOISE_BOUND, here)
        assert np.all(np.abs(error) <= without_noise)


@pytest.mark.parametrize("kind", ["tare", "payload"])
@pytest.mark.parametrize("axis", [0, 1])
def test_who_turns_round_on_a_ramp_needs_the_tilt_twice_and_no_more(kind: str, axis: int) -> None:
    turn = 0.005 * np.eye(3)[axis]
    # A mass as heavy and as far from the tool as is declared.
    sensor = Sensor(mass=0.83, com=TOOL_OFFSET - (0.0, 0.0, 0.1), gravity=rotation_from_vector(turn) @ DOWN)
    moment, zeros = sensor.mass * sensor.com, np.zeros(6)
    known = Compensation("payload", mass=sensor.mass, moment=moment) if kind == "payload" else Compensation()
    known = known.tared(sensor.exact(LEVEL), zeros, zeros, LEVEL)
    sensor.gravity = rotation_from_vector(-turn) @ DOWN
    error = np.abs(external_wrench(sensor.exact(LEVEL), known, LEVEL, TOOL_OFFSET))
    without_noise = bound(known, LEVEL, tilt=0.005) - transported(NOISE_BOUND, LEVEL)
    felt = error > 1e-6
    assert felt.sum() == 2 and np.all(error <= without_noise)
    assert error[felt] == pytest.approx(without_noise[felt], rel=1e-3)


def test_bias_error_grows_with_age_up_to_that_of_a_sensor_without_a_zero() -> None:
    tared = Compensation("tare", bias_error=0.1 * np.ones(6))
    drift = np.full(6, 0.2)
    assert bias_error(tared, 0.0, drift, BIAS_BOUND) == pytest.approx(np.full(6, 0.1))
    assert bias_error(tared, 90.0, drift, BIAS_BOUND)[0] == pytest.approx(0.1 + 0.3)
    assert bias_error(tared, 1e5, drift, BIAS_BOUND) == pytest.approx(BIAS_BOUND)
    assert bias_error(tared, NO_ZERO, drift, BIAS_BOUND) == pytest.approx(BIAS_BOUND)
    assert bias_error(tared, NO_ZERO, drift, np.zeros(6)) == pytest.approx(np.full(6, 0.1))


def test_what_the_default_tilt_costs() -> None:
    tared = Compensation().tared(np.zeros(6), np.zeros(6), np.zeros(6), LEVEL)
    cost = bound(tared, LEVEL, tilt=0.005) - bound(tared, LEVEL)
    assert cost == pytest.approx([2 * 0.005 * 0.83 * 9.81] * 3 + [2 * 0.005 * 0.083 * 9.81] * 3, rel=1e-3)
