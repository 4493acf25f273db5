"""The low pass' lag is the one that its parameter documents."""

from __future__ import annotations

import math

import numpy as np
import pytest

from services.wrench.lowpass import LowPass


@pytest.mark.parametrize("cutoff", [2.0, 10.0])
def test_a_ramp_comes_out_late_by_the_documented_lag(cutoff: float) -> None:
    lowpass, dt = LowPass(), 1e-3
    for n in range(3000):
        out = lowpass.filter(n * dt * np.ones(6), cutoff, dt)
    assert 3000 * dt - dt - out[0] == pytest.approx(1 / (2 * math.pi * cutoff), rel=0.05)


def test_off_passes_everything() -> None:
    lowpass = LowPass()
    lowpass.filter(np.zeros(6), 0.0, 0.01)
    assert lowpass.filter(np.ones(6), 0.0, 0.01) == pytest.approx(np.ones(6))


def test_first_value_after_a_reset_passes_unchanged() -> None:
    lowpass = LowPass()
    lowpass.filter(np.zeros(6), 1.0, 0.01)
    assert lowpass.filter(np.ones(6), 1.0, 0.01)[0] < 0.1
    lowpass.reset()
    assert lowpass.filter(np.ones(6), 1.0, 0.01) == pytest.approx(np.ones(6))
