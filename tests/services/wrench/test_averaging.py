"""Averages of a tool at rest, and the refusal of anything else."""

from __future__ import annotations

import numpy as np
import pytest

from services.wrench.averaging import Average, AveragingWindow, NotStill
from shared.spatial import Array, rotation_from_vector, rotation_vector
from tests.services.wrench.sensor import LEVEL, NOISE, NOISE_BOUND, Sensor

DT = 0.01


def averaged(
    readings: list[Array], rotations: list[Array] | None = None, duration: float | None = None
) -> Average:
    window = AveragingWindow(duration or DT * (len(readings) - 1) - 1e-9, NOISE_BOUND)
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


def test_too_few_samples() -> None:
    sensor = Sensor()
    with pytest.raises(NotStill, match="only 5 samples"):
        averaged([sensor.reading(LEVEL) for _ in range(5)])


def test_swinging_force_names_the_axis() -> None:
    sensor = Sensor()
    swing = [sensor.reading(LEVEL) + np.array((0, 4 * np.sin(0.3 * n), 0, 0, 0, 0)) for n in range(100)]
    with pytest.raises(NotStill, match="force y varies"):
        averaged(swing)


def test_slow_push_is_noticed_by_its_drift() -> None:
    sensor = Sensor()
    push = [sensor.reading(LEVEL) + np.array((0, 0, 0.01 * n, 0, 0, 0)) for n in range(100)]
    with pytest.raises(NotStill, match="force z drifts"):
        averaged(push)


def test_turning_is_noticed() -> None:
    sensor = Sensor()
    rotations = [rotation_from_vector((0.0, 0.0003 * n, 0.0)) for n in range(100)]
    with pytest.raises(NotStill, match=r"turned by 0\.030 rad"):
        averaged([sensor.reading(rotation) for rotation in rotations], rotations)


def test_orientation_is_averaged_too() -> None:
    sensor = Sensor()
    rotations = [rotation_from_vector((0.0, 0.004 * (n % 2), 0.0)) for n in range(100)]
    average = averaged([sensor.reading(LEVEL) for _ in rotations], rotations)
    assert rotation_vector(average.rotation) == pytest.approx([0.0, 0.002, 0.0], abs=1e-6)
