"""Identification finds the payload within its own stated sigma, and says which motion is missing."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from services.wrench.averaging import Average
from services.wrench.identification import NotExciting, identify
from shared.spatial import rotation_from_vector
from tests.services.wrench.sensor import NOISE, TILTED, Sensor


def about(axis: str, *angles: float) -> list[np.ndarray]:
    unit = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}[axis]
    return [rotation_from_vector(angle * np.array(unit, dtype=float)) for angle in angles]


@given(
    mass=st.floats(0.3, 5.0), com=st.tuples(*[st.floats(-0.2, 0.2)] * 3), bias=st.tuples(*[st.floats(-5.0, 5.0)] * 6)
)
@settings(max_examples=50)
def test_exact_readings_give_the_exact_payload(mass: float, com: tuple[float, ...], bias: tuple[float, ...]) -> None:
    sensor = Sensor(mass, np.array(com), np.array(bias))
    poses = [Average(sensor.exact(rotation), np.zeros(6), 100, rotation) for rotation in TILTED]
    result = identify(poses)
    assert result.mass == pytest.approx(mass)
    assert result.com == pytest.approx(np.array(com), abs=1e-9)
    assert result.force_bias == pytest.approx(sensor.bias[:3], abs=1e-9)
    assert result.torque_bias == pytest.approx(sensor.bias[3:], abs=1e-9)
    assert np.all(result.residual_peak < 1e-9)


def test_errors_are_as_large_as_stated() -> None:
    """Over many noisy identifications the errors divided by their sigma have a standard deviation of about one."""
    ratios = []
    for seed in range(120):
        sensor = Sensor(seed=seed)
        result = identify([sensor.average(rotation, samples=30) for rotation in TILTED])
        ratios.append(
            np.concatenate(
                (
                    [(result.mass - sensor.mass) / result.sigma_mass],
                    (result.com - sensor.com) / result.sigma_com,
                    (result.force_bias - sensor.bias[:3]) / result.sigma_force_bias,
                    (result.torque_bias - sensor.bias[3:]) / result.sigma_torque_bias,
                )
            )
        )
    spread = np.sqrt(np.mean(np.square(ratios), axis=0))
    assert np.all(spread < 1.2), "errors larger than stated"
    assert np.all(spread > 0.5), "errors stated far too large"
    assert np.max(np.abs(ratios)) < 5.0


def test_residuals_of_a_sensor_that_does_not_follow_the_model_widen_the_bound() -> None:
    sensor = Sensor(noise=np.zeros(6))
    rng = np.random.default_rng(1)
    poses = [
        Average(sensor.exact(rotation) + 1.0 * rng.standard_normal(6), 0.01 * np.ones(6), 100, rotation)
        for rotation in TILTED
    ]
    result = identify(poses)
    known = result.compensation()
    assert np.all(known.bias_error >= result.residual_peak)
    assert known.bias_error[:3].min() > 1.0


NOT_EXCITING = {
    "no pose": ([], 0.8, "0 poses"),
    "two poses": (TILTED[:2], 0.8, "2 poses"),
    "about the vertical": (about("z", 0.0, 1.0, 2.0, 3.0), 0.8, r"tilt varies by only 0\.0 degrees"),
    "about x alone": (about("x", -0.2, -0.1, 0.1, 0.2), 0.8, "about its y axis"),
    "about y alone": (about("y", -0.2, -0.1, 0.1, 0.2), 0.8, "about its x axis"),
    "no weight": (TILTED, 0.0, "does not stand out"),
}


@pytest.mark.parametrize("name", NOT_EXCITING)
def test_poses_that_do_not_determine_it_are_refused_with_what_is_missing(name: str) -> None:
    rotations, mass, words = NOT_EXCITING[name]
    sensor = Sensor(mass=mass)
    with pytest.raises(NotExciting, match=words):
        identify([sensor.average(rotation) for rotation in rotations])


def test_the_motion_that_was_named_mends_it() -> None:
    sensor = Sensor()
    rotations = about("x", -0.6, 0.0, 0.6) + about("y", -0.6, 0.6)
    assert identify([sensor.average(rotation) for rotation in rotations]).condition < 30


def test_noise_of_the_readings_is_reported() -> None:
    sensor = Sensor()
    result = identify([sensor.average(rotation) for rotation in TILTED])
    assert result.noise == pytest.approx(5 * NOISE, rel=0.5)
