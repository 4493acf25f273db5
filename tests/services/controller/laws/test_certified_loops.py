"""The limits in small closed loops: a wall at 30 Hz, and the two cases that break every simpler form of the law."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.contact import scripted
from benchmarks.contact.adversary import KINDS
from benchmarks.contact.cases import Case, Target
from benchmarks.contact.elastic import Surface
from benchmarks.contact.laws import make_law
from benchmarks.contact.simulate import Result, simulate
from benchmarks.contact.world import Contact

LIMIT = np.array((25.0,) * 3 + (10.0,) * 3)
FORMS = ("certified", "certified-rounded")
STRICT_ROUNDING = 1.0 + 1e-6


def run(law: str, case: Case) -> Result:
    caller = make_law(law, case)
    result = simulate(caller, keep_trace=True)
    assert not caller.failures
    return result


def into_a_wall(stiffness: float, rate: float, late: int, seconds: float) -> Case:
    """Driven 0.25 m into it; commands come late by some periods."""
    wall = Contact(np.zeros(3), True, Surface(np.array((-1.0, 0, 0)), np.array((0.05, 0, 0)), stiffness))
    target = Target(0.0, np.array((0.3, 0, 0)), np.eye(3))
    case = scripted.still("wall", (wall,), LIMIT, (target,), seconds)
    declared = scripted.declared(stiffness, (0.02,) * 3, weight=1.0)
    return replace(case, timing=scripted.timing(1.0 / rate, late / rate), declared=declared)


def last_path(result: Result) -> float:
    """Path [m] of the last second."""
    trace = result.trace
    assert trace is not None
    steps = np.diff(trace.position[trace.times > trace.times[-1] - 1.0], axis=0)
    return float(np.linalg.norm(steps, axis=1).sum())


@pytest.mark.parametrize(("stiffness", "peak"), [(2e3, 31.0), (1e4, 57.0), (1e5, 355.0)])
def test_paper_law_at_30_hz_exceeds_the_limit_and_goes_on_oscillating(stiffness: float, peak: float) -> None:
    result = run("paper", into_a_wall(stiffness, 30.0, 0, 6.0))
    assert result.peak == pytest.approx(peak / 25.0, rel=0.3)
    assert result.peak > 1.2 and last_path(result) > 1e-3


@pytest.mark.parametrize("law", FORMS)
@pytest.mark.parametrize("stiffness", [2e3, 1e4, 1e5])
@pytest.mark.parametrize(("rate", "late"), [(30.0, 0), (30.0, 2), (100.0, 3)])
def test_certified_law_keeps_the_limit_and_comes_to_rest(law: str, stiffness: float, rate: float, late: int) -> None:
    result = run(law, into_a_wall(stiffness, rate, late, seconds=30.0 if stiffness > 5e4 else 8.0))
    assert result.peak <= STRICT_ROUNDING
    assert result.peak > 0.7, "and it does press"
    assert last_path(result) < 1e-4


@pytest.mark.parametrize("law", FORMS)
@pytest.mark.parametrize("adversary", KINDS)
def test_oblique_spring_with_errors_against_it(law: str, adversary: str) -> None:
    """Eigenvalues 1 and 0.1 of kappa at 45 degrees: retreating from a false excess on x pushes y over its limit."""
    # At 30 Hz, two periods late; error bounds of 0.3 N, and of 1.5 N where the number is odd.
    late = {"timing": scripted.timing(1 / 30, 2 / 30), "quiet": 1.6, "duration": 2.0, "adversary": adversary}
    cases = [replace(scripted.oblique_spring(number), **late) for number in (2, 6, 15, 26, 46, 62)]
    peaks = [run(law, case).peak for case in cases]
    assert max(peaks) <= STRICT_ROUNDING
    assert max(peaks) > 0.6, "and the spring is really loaded"


@pytest.mark.parametrize("law", FORMS)
@pytest.mark.parametrize("number", range(6))
def test_turning_a_face_that_is_pressed_on_a_point(law: str, number: int) -> None:
    """The force turns with the face from one axis into another, which only the geometric part G of the bound counts."""
    result = run(law, scripted.turning_face(number))
    assert 0.7 < result.peak <= STRICT_ROUNDING
    assert result.turned > 0.01
