"""The nominal wrench: down with the measured force, never faster than its ramp, never beyond half the weight."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from services.task.nominal_wrench import LIFT_RATE, RELEASE_RATE, NominalWrench

HALF = 7.36
forces = st.lists(st.floats(-40.0, 40.0), min_size=1, max_size=200)


@given(forces)
def test_in_the_lift_it_only_goes_down_with_what_is_measured(measured: list[float]) -> None:
    nominal = NominalWrench(HALF)
    before = 0.0
    for force in measured:
        now = nominal.carry(force, 0.02)
        assert -HALF <= now <= before <= 0.0
        assert before - now <= LIFT_RATE * 0.02 + 1e-9
        assert now == before or now >= force
        before = now


def test_it_latches_at_half_the_weight() -> None:
    nominal = NominalWrench(HALF)
    for _ in range(100):
        nominal.carry(-9.0, 0.02)
    assert nominal.supported and nominal.force == -HALF
    assert nominal.carry(5.0, 0.02) == -HALF


def test_it_is_no_lift_before_half_of_it_is_carried() -> None:
    nominal = NominalWrench(HALF)
    for _ in range(100):
        nominal.carry(-0.4 * HALF, 0.02)
    assert not nominal.supported


@given(forces)
def test_it_fades_to_zero_at_its_rate(_measured: list[float]) -> None:
    nominal = NominalWrench(HALF, -HALF, True)
    steps = 0
    while nominal.force < 0.0:
        before = nominal.force
        assert nominal.fade(0.02) - before <= RELEASE_RATE * 0.02 + 1e-9
        steps += 1
    assert steps == pytest.approx(HALF / RELEASE_RATE / 0.02, abs=1)
    assert nominal.fade(0.02) == 0.0 and nominal.supported


def test_what_is_recalled_stays_within_the_weight() -> None:
    assert NominalWrench(HALF, -100.0).force == -HALF
    assert NominalWrench(HALF, 3.0).force == 0.0
