"""What all laws do alike: free convergence, rest at the target, and a brake where numbers cannot be trusted."""

from __future__ import annotations

import math

import numpy as np
import pytest

from services.controller.laws import LAWS, make_law
from tests.services.controller.contacts import agile, state

each_law = pytest.mark.parametrize("name", LAWS)
VECTORS = ("wrench", "limit", "error_bound", "position", "target_position", "nominal")


@each_law
def test_without_wrench_all_laws_converge_alike(name: str) -> None:
    """The multiplier is capped at k: ``v = -min(k, lambda)/2 e``."""
    law = make_law(agile(law=name, contact_stiffness=1.0, contact_reach=(0.01,) * 3))
    output = law.step(state(position=[0.1, -0.05, 0.02], turn=[0.0, 0.0, 0.1]), 0.01)
    assert output.twist == pytest.approx([-0.05, 0.025, -0.01, 0, 0, -0.05], abs=1e-6)


@each_law
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize(
    ("field", "value"),
    [
        *((field, value) for field in VECTORS for value in (math.nan, math.inf, -math.inf, 1e200)),
        *((field, value) for field in ("rotation", "target_rotation") for value in (math.nan, math.inf)),
    ],
)
def test_what_is_not_finite_brakes_in_the_same_tick(name: str, field: str, value: float) -> None:
    law, spoilt = make_law(agile(law=name)), state(target=[0.3, 0, 0])
    changed = getattr(spoilt, field).copy()
    changed.flat[-3] = value
    setattr(spoilt, field, changed)
    output = law.step(spoilt, 0.01)
    assert output.failure and not output.twist.any()
    after = law.step(state(target=[0.3, 0, 0]), 0.01)
    assert after.failure is None and after.twist[0] > 0


@pytest.mark.parametrize("dt", [math.nan, math.inf, -1.0])
def test_dt_that_is_no_duration_is_no_time(dt: float) -> None:
    assert np.isfinite(make_law(agile()).step(state(target=[0.3, 0, 0]), dt).twist).all()


@each_law
@pytest.mark.parametrize("away", [0.0, 1e-15, 1e-12, 1e-10, 1e-8, 1.1e-7, 1e-6])
def test_at_the_target_the_solver_finds_that_there_is_nothing_to_do(name: str, away: float) -> None:
    """A pose error that rounding leaves would give the Lyapunov row a multiplier below every tolerance."""
    law = make_law(agile(law=name))
    for wrench in ([0.0] * 6, [3.0, 0.0, 0.0, 0.0, 0.0, 0.0]):
        for _ in range(3):
            output = law.step(state(wrench=wrench, position=[away, 0.0, 0.0]), 0.01)
            assert output.failure is None
            if name != "stiffness":  # a spring gives way to any wrench
                assert np.abs(output.twist).max() <= 2.0 * away + 1e-6
