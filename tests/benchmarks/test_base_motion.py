"""What the base's motion adds to the tool's and to the wrench, against rigid transforms and random contacts."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.base_motion import PEAK, TOOL, declared, main, speed_limits, tool_twist, wrench_rates
from shared.spatial import Array, rotation_from_vector, skew

PAGE = Path(__file__).parents[2] / "docs" / "base.md"
REACH = np.array((1.2, 0.3, 0.05))
LIMIT = np.array((10.0, 10.0, 10.0, 0.5, 3.0, 3.0))
RESPONSE = 0.06


@pytest.fixture(scope="module")
def stiffness() -> Array:
    return declared()


parts = st.floats(-1, 1)


@given(st.tuples(parts, parts, parts), st.tuples(parts, parts, parts))
def test_the_tool_moves_as_a_point_of_the_base(velocity, position) -> None:
    dt = 1e-6
    turn = rotation_from_vector((0.0, 0.0, dt * velocity[2]))
    moved = turn @ np.array(position) + dt * np.array((velocity[0], velocity[1], 0.0))
    twist = tool_twist(velocity, position)
    assert twist[:3] == pytest.approx((moved - position) / dt, abs=1e-5)
    assert tuple(twist[3:]) == (0.0, 0.0, velocity[2])


def test_no_contact_as_declared_changes_the_wrench_faster(stiffness: Array) -> None:
    """The environment's force on the tool is elastic and turns with the ground under the base."""
    random = np.random.default_rng(1)
    per_speed, per_turn = wrench_rates(stiffness, TOOL)
    most = np.zeros(6)
    for _ in range(3000):
        point = random.uniform(-1.0, 1.0, 3) * REACH
        axes = np.linalg.qr(random.normal(size=(3, 3)))[0]
        spring = axes @ np.diag(random.choice((0.0, 1.0), 3)) @ axes.T * 500.0
        angle = random.uniform(0.0, 2 * math.pi)
        speed, turn = random.choice(((0.3, 0.0), (0.0, 0.3), (0.2, 0.2)))
        twist = tool_twist((speed * math.cos(angle), speed * math.sin(angle), turn), TOOL)
        slip = twist[:3] + np.cross(twist[3:], point)
        force = random.uniform(-1.0, 1.0, 3) * LIMIT[:3]
        # In turning axes a force at rest on the ground turns backwards, and its point of attack with it.
        rate_of_force = -spring @ slip - random.choice((0.0, 1.0)) * np.cross(twist[3:], force)
        rate_of_arm = -random.choice((0.0, 1.0)) * np.cross(twist[3:], point)
        rate = np.concatenate((rate_of_force, skew(point) @ rate_of_force + np.cross(rate_of_arm, force)))
        share = np.abs(rate) / (per_speed * speed + per_turn * turn)
        most = np.maximum(most, share)
    assert most.max() <= 1.0
    assert most[:3].min() > 0.4, "the bound is not idle"


def test_at_the_limits_the_worst_axis_peaks_at_the_wanted_excess(stiffness: Array) -> None:
    speed, turn = speed_limits(stiffness, TOOL, LIMIT, 0.2, RESPONSE)
    per_speed, per_turn = wrench_rates(stiffness, TOOL)
    for share in (0.0, 0.3, 1.0):
        rise = RESPONSE * (per_speed * share * speed + per_turn * (1.0 - share) * turn)
        peak = PEAK * np.max(rise / LIMIT)
        assert peak <= 0.2 + 1e-12
        assert share not in (0.0, 1.0) or peak == pytest.approx(0.2)


def test_the_documentation_says_what_the_command_prints(capsys: pytest.CaptureFixture[str]) -> None:
    main([])
    *table, _, sentence = capsys.readouterr().out.splitlines()
    page = PAGE.read_text(encoding="utf-8").splitlines()
    told = [line.split("|")[2:-1] for line in page if line.startswith("|") and line.count("|") == 8]
    assert [line.split("|")[2:-1] for line in table] == told
    assert sentence == "For an excess of 1 limits: 0.021 m/s, or 0.014 rad/s."
    assert "**0.021 m/s or turn at 0.014 rad/s**" in "\n".join(page)


def test_limits_scale_with_excess_and_against_response_and_stiffness(stiffness: Array) -> None:
    base = np.array(speed_limits(stiffness, TOOL, LIMIT, 0.1, RESPONSE))
    assert speed_limits(stiffness, TOOL, LIMIT, 0.3, RESPONSE) == pytest.approx(3 * base)
    assert speed_limits(stiffness, TOOL, LIMIT, 0.1, 2 * RESPONSE) == pytest.approx(base / 2)
    assert speed_limits(4 * stiffness, TOOL, LIMIT, 0.1, RESPONSE) == pytest.approx(base / 4)
