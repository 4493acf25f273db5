"""The stiffness that a contact shows is found from the tool's own motion, and never beyond its bounds."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from services.controller.bounds.contact_softness import FIRST_SHARE, ContactSoftness

D, DT = 0.05, 0.005
SCALE = np.sqrt((800.0, 800.0, 800.0, 90.0, 90.0, 90.0))
LARGEST = 2.0


def step(softness: ContactSoftness, wrench: np.ndarray, moved: np.ndarray, noise: float = 0.0, dt: float = DT) -> float:
    """The share after a step in which errors hide ``noise`` on each axis, in the scale."""
    return softness.step(wrench, moved, SCALE, LARGEST, noise * np.sqrt(6.0), D, dt)


def learnt(share: float, drift: np.ndarray, noise: float = 0.0, steps: int = 200) -> float:
    """A tool that swings by millimetres against a contact of ``share`` of the declared stiffness that drifts away."""
    rng = np.random.default_rng(0)
    direction = np.array((1.0, 0.0, 0.0, 0.0, 0.8, 0.0)) / SCALE
    matrix = share * LARGEST * np.diag(SCALE**2)
    softness, moved, before = ContactSoftness(), [np.zeros(6)], np.zeros(6)
    for count in range(steps):
        acted = moved[max(0, len(moved) - 1 - round(0.75 * D / DT))]
        wrench = count * DT * drift - matrix @ acted + noise * SCALE * rng.uniform(-1.0, 1.0, 6)
        step(softness, wrench, moved[-1] - before, noise)
        before = moved[-1]
        moved.append(np.sin(count * DT / D) * 0.1 * direction)
    return softness.share


@pytest.mark.parametrize("share", [0.1, 0.2, 0.5, 1.0])
def test_share_is_found_whatever_the_steady_drift(share: float) -> None:
    drift = np.array((40.0, -20.0, 0.0, 3.0, 10.0, 0.0))
    assert learnt(share, np.zeros(6)) == pytest.approx(share, rel=0.05)
    assert learnt(share, drift) == pytest.approx(share, rel=0.05)


@pytest.mark.parametrize(("share", "expected"), [(0.01, 0.1), (3.0, 1.0)])
def test_share_stays_within_its_bounds(share: float, expected: float) -> None:
    assert learnt(share, np.zeros(6)) == pytest.approx(expected, rel=1e-3)


def test_motion_that_errors_hide_teaches_nothing() -> None:
    assert learnt(0.1, np.zeros(6), noise=10.0) == pytest.approx(FIRST_SHARE, abs=0.05)
    assert step(ContactSoftness(), np.full(6, 5.0), np.zeros(6), 1e-3) == FIRST_SHARE


def test_a_stiffer_contact_is_believed_sooner_than_a_softer_one() -> None:
    for steps in (18, 20, 22):  # about two response times from the first motion
        still_to_learn = (1.0 - learnt(1.0, np.zeros(6), steps=steps)) / 0.5
        assert still_to_learn < 0.6 * (learnt(0.25, np.zeros(6), steps=steps) - 0.25) / 0.25


@given(st.lists(st.tuples(st.floats(-1e3, 1e3), st.floats(-1.0, 1.0), st.floats(0.0, 0.2)), min_size=1, max_size=60))
def test_any_history_gives_a_share_within_bounds(history: list[tuple[float, float, float]]) -> None:
    softness = ContactSoftness()
    for wrench, moved, dt in history:
        share = step(softness, np.full(6, wrench), np.full(6, moved * dt), 0.1, dt)
        assert 0.1 <= share <= 1.0


def test_the_regression_runs_when_a_sample_is_kept_and_not_in_between(monkeypatch: pytest.MonkeyPatch) -> None:
    softness, runs = ContactSoftness(), []
    regression = softness._regression
    monkeypatch.setattr(softness, "_regression", lambda *given: runs.append(softness._now) or regression(*given))
    for count in range(1000):
        step(softness, np.zeros(6), np.full(6, 1e-3 * np.sin(count)), dt=0.0002)
    assert len(runs) == pytest.approx(0.2 / (2.5 * D / 40), rel=0.15)
