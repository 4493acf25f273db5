"""A fit that does not explain its data is refused, with what would; one that does is not."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from services.wrench.averaging import Average
from services.wrench.identification import NoWeight, identify, misfit
from services.wrench.suspects import suspects, unexplained, unmoved
from shared.spatial import Array, rotation_from_vector
from tests.services.wrench.sensor import NOISE, TILTED, Sensor

TILT = 0.01
NOISY = NOISE / 50

AXIS = np.arange(6)


def poses(change: Callable[[Array, Array], Array] = lambda reading, rotation: reading, seed: int = 0) -> list[Average]:
    sensor, random = Sensor(bias=np.zeros(6)), np.random.default_rng(seed)
    more = [*TILTED, rotation_from_vector((0.5, 0.5, 0.0)), rotation_from_vector((-0.5, 0.4, 0.2))]
    return [Average(change(sensor.exact(r), r) + NOISY * random.standard_normal(6), 10 * NOISY, 100, r) for r in more]


def axes(matrix: Array) -> Callable[[Array, Array], Array]:
    return lambda reading, rotation: np.kron(np.eye(2), matrix) @ reading


def said(taken: list[Average]) -> str:
    try:
        return unexplained(identify(taken), taken, TILT)
    except NoWeight:
        return suspects(taken, TILT)


@pytest.mark.parametrize("noise", [0.2, 1.0, 5.0])
def test_white_noise_is_explained(noise: float) -> None:
    """The stated false alarm rate is one in 30,000: none of 100 identifications of a sound sensor."""
    for seed in range(100):
        sensor = Sensor(noise=noise * NOISE, seed=seed)
        taken = [
            Average(sensor.exact(r) + sensor.noise / 10 * sensor._random.standard_normal(6), sensor.noise, 100, r)
            for r in TILTED
        ]
        assert misfit(identify(taken), taken, 0.0).max() <= 1.0


@given(degrees=st.floats(5.0, 180.0), sign=st.sampled_from([-1, 1]), inverted=st.booleans(), seed=st.integers(0, 9))
@settings(max_examples=40, deadline=None)
def test_a_turn_about_z_is_found_to_a_degree(degrees: float, sign: int, inverted: bool, seed: int) -> None:
    turn = rotation_from_vector((0.0, 0.0, math.radians(sign * degrees)))
    text = said(poses(axes((-1 if inverted else 1) * turn), seed))
    if degrees > 179.0:
        return  # either sign is the same turn
    words = text.split("turned by ")[1].split(" degrees about z")
    assert abs(float(words[0]) - sign * degrees) <= 1.0
    assert ("opposite sign" in words[1]) == inverted and "would fit, rms 0.0" in text


KINDS = {
    "45 degrees": (axes(rotation_from_vector((0, 0, math.pi / 4))), "turned by 45 degrees about z would fit"),
    "sign": (lambda reading, rotation: -reading, "the opposite sign would fit"),
    "base axes": (lambda reading, rotation: np.kron(np.eye(2), rotation) @ reading, "base axes"),
    "another turn": (axes(rotation_from_vector((1.0, 0, 0))), "turned by 57 degrees about (+1.00"),
    "mirrored": (axes(np.diag((-1.0, 1.0, 1.0))), "mirrored"),
    "touched once": (
        lambda reading, rotation: reading + (2.0 if rotation is TILTED[2] else 0.0) * np.eye(6)[1],
        "a touch in pose 3: without it the rest would fit",
    ),
    "gains": (axes(np.diag((1.2, 0.8, 1.0))), "gains or units"),
}


@pytest.mark.parametrize("name", KINDS)
def test_what_would_fit_is_named(name: str) -> None:
    change, words = KINDS[name]
    assert words in said(poses(change))


@given(gains=st.tuples(*[st.floats(-0.05, 0.05)] * 36), turn=st.tuples(*[st.floats(-3.0, 3.0)] * 3))
@settings(max_examples=100, deadline=None)
def test_what_the_poses_left_bounds_every_linear_effect_in_every_attitude(
    gains: tuple[float, ...], turn: tuple[float, ...]
) -> None:
    """Gains, crosstalk, misalignment: outside of the cone of the poses too."""
    sensor, matrix = Sensor(), np.eye(6) + np.array(gains).reshape(6, 6)
    result = identify([Average(matrix @ sensor.exact(r), np.zeros(6), 100, r) for r in TILTED])
    known, rotation = result.compensation(), rotation_from_vector(turn)
    error = np.abs(matrix @ sensor.exact(rotation) - known.offset(rotation))
    # Directions that no pose has shown are taken to be known to 0.01 (`_SHARPEST`).
    assert np.all(error <= 1.1 * known.misfit(rotation[2]) + 1e-3)


def test_far_from_the_poses_less_is_stated() -> None:
    known = identify(poses()).compensation()
    near, far = known.misfit(np.array((0.0, 0.0, 1.0))), known.misfit(np.array((0.0, 0.0, -1.0)))
    assert np.all(far > 3 * near)


def test_an_axis_that_feels_nothing_is_named() -> None:
    """It would be identified as one without any weight on it; where no axis has noise, it may be a simulator's."""
    taken = poses()
    dead = [
        replace(pose, mean=pose.mean * (AXIS != 4) + 1e-16 * k, std=pose.std * (AXIS != 4))
        for k, pose in enumerate(taken)
    ]
    assert unmoved(dead) == "torque y was 0 Nm in every pose, while other axes move: it feels nothing."
    assert not unmoved(taken)
    assert not unmoved([replace(pose, std=np.zeros(6)) for pose in dead])
