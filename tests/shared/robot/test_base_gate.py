"""The base's gate against its closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from shared.robot.base_gate import BaseGate, BaseLimits

DT = 0.002
DIFFERENTIAL = BaseLimits(1.0, 0.2, 0.0, 2.0, 1.0, 2.0)
OMNI = BaseLimits(1.0, 1.0, 1.0, 1.4, 1.0, 2.0, {"xy": 0.7, "xz": 0.5, "yz": 0.5, "xyz": 0.4})


def run(gate: BaseGate, duration: float, *velocity: float) -> np.ndarray:
    """Velocities (n, 3) while the command is repeated at 100 Hz; without one nobody speaks."""
    executed = []
    for step in range(round(duration / DT)):
        if velocity and step % 5 == 0:
            gate.command(np.array(velocity), 0.1, 0.0)
        executed.append(gate.advance(DT))
    return np.array(executed)


def test_it_speeds_up_at_its_acceleration() -> None:
    times = DT * np.arange(1, 501)
    executed = run(BaseGate(DIFFERENTIAL), 1.0, 0.4, 0.0, 0.0)
    assert executed[:, 0] == pytest.approx(np.minimum(times, 0.4), abs=1e-9)


def test_the_axis_that_takes_longest_sets_the_pace_of_all() -> None:
    executed = run(BaseGate(OMNI), 0.25, 0.3, 0.0, 0.2)
    assert executed[:, 2] == pytest.approx(executed[:, 0] / 0.3 * 0.2)
    assert np.diff(executed[:100, 0]) == pytest.approx(DT)


@pytest.mark.parametrize(
    ("limits", "asked", "executed"),
    [
        (DIFFERENTIAL, (3.0, 0.0, 0.0), (1.0, 0.0, 0.0)),
        (DIFFERENTIAL, (-1.0, 0.0, 0.5), (-0.2, 0.0, 0.1)),
        (DIFFERENTIAL, (0.1, 0.5, 0.0), (0.1, 0.0, 0.0)),
        (DIFFERENTIAL, (0.0, 0.0, 4.0), (0.0, 0.0, 2.0)),
        (OMNI, (0.0, -2.0, 0.0), (0.0, -1.0, 0.0)),
        (OMNI, (1.0, 1.0, 0.0), (0.7, 0.7, 0.0)),
        (OMNI, (1.0, 0.0, 1.4), (0.5, 0.0, 0.7)),
        (OMNI, (1.0, 1.0, 1.4), (0.4, 0.4, 0.56)),
        (BaseLimits(1.0, 0.0, 0.0, 2.0, 1.0, 2.0), (-0.5, 0.0, 0.5), (0.0, 0.0, 0.5)),
        (BaseLimits(0.0, 0.2, 0.0, 2.0, 1.0, 2.0), (0.5, 0.0, 3.0), (0.0, 0.0, 2.0)),
        (BaseLimits(1.0, 0.2, 0.5, 0.0, 1.0, 2.0), (0.3, 0.2, 0.1), (0.3, 0.2, 0.0)),
        (BaseLimits(0.0, 0.0, 0.0, 0.0, 1.0, 2.0), (0.3, 0.2, 0.1), (0.0, 0.0, 0.0)),
    ],
)
def test_an_excess_is_shortened_as_a_whole_and_counted(
    limits: BaseLimits, asked: tuple[float, ...], executed: tuple[float, ...]
) -> None:
    gate = BaseGate(limits)
    assert run(gate, 3.0, *asked)[-1] == pytest.approx(executed)
    assert gate.clamped > 0


@pytest.mark.parametrize(
    ("limits", "asked", "ttl", "limit"),
    [
        (DIFFERENTIAL, (-0.5, 0.0, 0.0), 0.1, "backwards over 0.2 m/s"),
        (DIFFERENTIAL, (1.5, 0.1, 3.0), 0.1, "forwards over 1 m/s and sideways over 0 m/s and turning over 2 rad/s"),
        (OMNI, (0.6, 0.0, 0.9), 0.1, "forwards and turning together over 0.5 of their limits"),
        (OMNI, (0.0, 0.0, -3.0), 0.1, "turning over 1.4 rad/s"),
        (OMNI, (0.1, 0.0, 0.0), 0.5, "ttl over 0.2 s"),
    ],
)
def test_the_limit_is_named(limits: BaseLimits, asked: tuple[float, ...], ttl: float, limit: str) -> None:
    gate = BaseGate(limits)
    gate.command(np.array(asked), ttl, 0.0)
    assert (gate.clamped, gate.clamped_by) == (1, limit)


def test_rest_is_no_excess_of_a_base_that_cannot_move() -> None:
    gate = BaseGate(BaseLimits(0.0, 0.0, 0.0, 0.0, 1.0, 2.0))
    assert not run(gate, 0.1, 0.0, 0.0, 0.0).any()
    assert gate.clamped == 0


def test_what_is_allowed_is_not_counted() -> None:
    gate = BaseGate(OMNI)
    assert run(gate, 2.0, 0.4, -0.4, 0.56)[-1] == pytest.approx((0.4, -0.4, 0.56))
    assert (gate.clamped, gate.late, gate.expired) == (0, 0, 0)


def test_silence_slows_it_down_along_its_path_once_the_command_has_expired() -> None:
    gate = BaseGate(OMNI)
    run(gate, 1.0, 0.3, -0.3, 0.4)
    silent = run(gate, 1.0)
    # The last command came four steps ago.
    times = DT * np.arange(1, 501)
    left = np.clip(0.3 * math.sqrt(2.0) - (times - (0.1 - 5 * DT)), 0.0, 0.3 * math.sqrt(2.0))
    assert np.hypot(silent[:, 0], silent[:, 1]) == pytest.approx(left, abs=1.1 * DT)
    moving = silent[:, 0] > 1e-9
    assert silent[moving, 2] / silent[moving, 0] == pytest.approx(0.4 / 0.3)
    assert not silent[-1].any()
    assert gate.expired == 1


def test_a_stop_slows_it_down_at_once_and_stays() -> None:
    gate = BaseGate(DIFFERENTIAL)
    run(gate, 1.0, 0.4, 0.0, 0.0)
    gate.stop(True)
    assert run(gate, 0.5, 0.4, 0.0, 0.0)[:, 0] == pytest.approx(np.maximum(0.4 - DT * np.arange(1, 251), 0.0), abs=1e-9)
    gate.stop(False)
    assert run(gate, 0.1, 0.4, 0.0, 0.0)[-1, 0] > 0.0


@pytest.mark.parametrize(
    ("velocity", "ttl", "age", "valid"),
    [
        ((math.nan, 0, 0), 0.1, 0.0, True),
        ((0.1, 0, 0), math.inf, 0.0, True),
        ((0.1, 0, 0), 0.1, 0.2, True),
        ((0.1, 0, 0), 0.1, 0.0, False),
    ],
    ids=["NaN", "endless", "late", "invalid"],
)
def test_what_is_no_command_means_stop(velocity: tuple[float, ...], ttl: float, age: float, valid: bool) -> None:
    gate = BaseGate(DIFFERENTIAL)
    run(gate, 0.5, 0.2, 0.0, 0.0)
    gate.command(np.array(velocity), ttl, age, valid)
    assert not run(gate, 0.5)[-1].any()
    assert gate.expired == 0


def test_a_longer_ttl_than_allowed_is_cut() -> None:
    gate = BaseGate(DIFFERENTIAL)
    gate.command(np.array((0.1, 0.0, 0.0)), 100.0, 0.0)
    executed = run(gate, 0.5)
    assert np.count_nonzero(executed[:, 0]) == pytest.approx((0.2 + 0.1) / DT, abs=2)
    assert (gate.clamped, gate.expired) == (1, 1)


@given(
    st.lists(
        st.tuples(*[st.floats(-1e6, 1e6)] * 3, st.floats(0.001, 0.3), st.floats(0.0, 0.3)), min_size=1, max_size=30
    )
)
def test_whatever_is_asked_stays_within_speed_and_acceleration(commands: list[tuple[float, ...]]) -> None:
    for limits in (DIFFERENTIAL, OMNI, BaseLimits(1.0, 0.0, 0.5, 0.0, 1.0, 2.0)):
        gate = BaseGate(limits)
        before = np.zeros(3)
        for *velocity, ttl, age in commands:
            gate.command(np.array(velocity), ttl, age)
            for _ in range(20):
                executed = gate.advance(DT)
                change = executed - before
                assert math.hypot(*change[:2]) <= limits.acceleration * DT * (1 + 1e-9)
                assert abs(change[2]) <= limits.angular_acceleration * DT * (1 + 1e-9)
                assert -limits.backwards - 1e-9 <= executed[0] <= limits.forwards + 1e-9
                assert (abs(executed) <= limits.largest + np.array((1e-9, 1e-9, 1e-9))).all()
                before = executed
