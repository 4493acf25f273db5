"""The limits in small closed loops: a wall at 30 Hz, and the two cases that break every simpler form of the law."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
import pytest

from services.controller.laws import make_law
from services.controller.laws.law import Law
from shared.spatial import rotation_from_vector
from tests.services.controller.contacts import agile, state

FINE = 10
"""Instants per period at which the wrench is looked at: the promise holds between samples too."""
FORMS = {"strict": 1.0, "rounded": 0.8}


def wall_loop(
    law: Law, stiffness: float, rate: float, late: int = 0, seconds: float = 6.0
) -> tuple[float, float]:
    """Drive the tool 0.25 m into a wall; largest force [N] and the path [m] of the last second.

    ``late``: periods by which commands come late.
    """
    limit = np.array([25.0] * 3 + [10.0] * 3)
    x, peak, path = np.zeros(3), 0.0, 0.0
    coming = [np.zeros(6)] * late
    steps = int(seconds * rate)
    for step in range(steps):
        wrench = np.array((-stiffness * max(0.0, x[0] - 0.05), 0, 0, 0, 0, 0))
        output = law.step(
            state(wrench, x, target=[0.3, 0, 0], limit=limit, error_bound=np.zeros(6)), 1 / rate
        )
        assert output.failure is None
        coming.append(output.twist)
        twist = coming.pop(0)
        for _ in range(FINE):
            x = x + twist[:3] / rate / FINE
            peak = max(peak, stiffness * (x[0] - 0.05))
        path += abs(twist[0]) / rate if step > steps - rate else 0.0
    return peak, path


@pytest.mark.parametrize(("stiffness", "peak"), [(2e3, 31.0), (1e4, 57.0), (1e5, 355.0)])
def test_paper_law_at_30_hz_exceeds_the_limit_and_goes_on_oscillating(stiffness: float, peak: float) -> None:
    found, path = wall_loop(make_law(agile(law="paper", period=1 / 30)), stiffness, 30.0)
    assert found == pytest.approx(peak, rel=0.3)
    assert found > 1.2 * 25.0 and path > 1e-3


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("stiffness", [2e3, 1e4, 1e5])
@pytest.mark.parametrize(("rate", "late"), [(30.0, 0), (30.0, 2), (100.0, 3)])
def test_certified_law_keeps_the_limit_and_comes_to_rest(
    form: str, stiffness: float, rate: float, late: int
) -> None:
    parameters = agile(
        contact_stiffness=stiffness,
        contact_reach=(0.02, 0.02, 0.02),
        yield_start=FORMS[form],
        period=1 / rate,
        delay=late / rate,
    )
    peak, path = wall_loop(
        make_law(parameters), stiffness, rate, late, seconds=30.0 if stiffness > 5e4 else 8.0
    )
    assert peak <= 25.0 * (1 + 1e-9)
    assert peak > 0.7 * 25.0, "and it does press"
    assert path < 1e-4


def spring_loop(
    law: Law, stiffness: np.ndarray, target: np.ndarray, errors: Callable, seconds: float = 2.0
) -> float:
    """A tool held by springs (3, 3) whose readings an adversary falsifies; largest |force| on any axis [N]."""
    limit, error_bound = np.full(6, 10.0), np.full(6, 1.5)
    x, peak, T = np.zeros(3), 0.0, 0.01
    for step in range(int(seconds / T)):
        force = -stiffness @ x
        wrench = np.concatenate((force + errors(step, force), np.zeros(3)))
        output = law.step(state(wrench, x, target=target, limit=limit, error_bound=error_bound), T)
        assert output.failure is None
        for _ in range(FINE):
            x = x + output.twist[:3] * T / FINE
            peak = max(peak, float(np.abs(stiffness @ x).max()))
    return peak


ADVERSARIES = {
    "constant": lambda step, force: np.array((1.5, -1.5, 0.0)),
    "outward": lambda step, force: 1.5 * np.sign(force),
    "inward": lambda step, force: -1.5 * np.sign(force),
    "alternating": lambda step, force: 1.5 * np.array((1.0, -1.0, 1.0)) * (-1) ** step,
    "turning": lambda step, force: 1.5 * np.sign(np.sin(step * np.array((0.3, 0.41, 0.57)))),
}


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("adversary", ADVERSARIES)
def test_oblique_spring_with_opposite_errors(form: str, adversary: str) -> None:
    """Eigenvalues 1 and 0.1 of kappa at 45 degrees: retreating from a false excess on x pushes y over its limit."""
    oblique = np.array(((0.55, 0.45, 0), (0.45, 0.55, 0), (0, 0, 0.1))) * 1000.0
    worst = 0.0
    for index, side in itertools.product(range(8), (1, -1)):
        angle = index * np.pi / 4
        law = make_law(agile(contact_stiffness=1000.0, contact_reach=(0.001,) * 3, yield_start=FORMS[form]))
        target = 0.3 * np.array((np.cos(angle), np.sin(angle), 0.2))
        worst = max(worst, spring_loop(law, oblique * [1, 1, 1], target * side, ADVERSARIES[adversary]))
    assert worst <= 10.0 * (1 + 1e-9)
    assert worst > 1.0, "and the springs are really loaded"


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("side", [1, -1])
def test_turning_a_face_that_is_pressed_on_a_point(form: str, axis: int, side: int) -> None:
    """Without the geometric part G the force turns with the face from one axis into another, over its limit."""
    stiffness, T, limit = 100.0, 0.01, np.array([10.0] * 3 + [30.0] * 3)
    law = make_law(
        agile(contact_stiffness=stiffness, contact_reach=(0.3,) * 3, yield_start=FORMS[form], max_angular=1.0)
    )
    share = 0.97 if form == "strict" else 0.8
    depth = share * 10.0 * np.sqrt(3.0) / stiffness
    face = np.array((1.0, 1.0, 1.0)) / np.sqrt(3.0)  # the face's normal, into the tool
    point = np.zeros(3)
    position, rotation, peak, turned = face * -depth * 0.0, np.eye(3), 0.0, 0.0
    offset = depth  # how far the fixed point has come in at the start
    goal = np.zeros(3)
    goal[axis] = 1.5 * side

    def wrench_at(position: np.ndarray, rotation: np.ndarray) -> np.ndarray:
        normal = rotation @ face
        arm = point - position
        force = stiffness * max(0.0, offset + normal @ arm) * normal
        return np.concatenate((force, np.cross(arm, force)))

    for _ in range(300):
        given = state(
            wrench_at(position, rotation), position, target_turn=goal, limit=limit, error_bound=np.zeros(6)
        )
        given.rotation = rotation
        given.target_position = position
        output = law.step(given, T)
        assert output.failure is None
        for _ in range(FINE):
            position = position + output.twist[:3] * T / FINE
            rotation = rotation_from_vector(output.twist[3:] * T / FINE) @ rotation
            peak = max(peak, float(np.abs(wrench_at(position, rotation) / limit).max()))
        turned += float(np.linalg.norm(output.twist[3:])) * T
    assert peak <= 1.0 + 1e-6
    assert turned > 0.01
