"""The gate: for any sequence of commands, stops and times, what is executed stays within its limits."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shared.robot.gate import LONGEST_TTL, SILENCE, Gate, GateLimits

LIMITS = GateLimits(0.25, 0.5, 1.0, 2.0)
DT = 0.002
FORWARDS = (0.1, 0.0, 0.0)
ROUNDING = 1e-9

anything = st.floats(allow_nan=True, allow_infinity=True) | st.floats(-1, 1) | st.sampled_from((0.0, 1e-320, 1e308))
ordinary = st.floats(-1.0, 1.0)


@dataclass(frozen=True)
class Command:
    linear: tuple[float, ...]
    angular: tuple[float, ...]
    ttl: float
    age: float
    valid: bool


def commands(number: st.SearchStrategy[float]) -> st.SearchStrategy[Command]:
    vector = st.tuples(number, number, number)
    return st.builds(Command, vector, vector, anything | st.floats(0.001, 0.3), anything | st.just(0.0), st.booleans())


events = st.lists(
    st.one_of(
        commands(anything),
        commands(ordinary),
        st.floats(0.0, 0.5),  # time passes
        st.floats(0.001, 0.01),
        st.booleans(),  # a stop is engaged or released
    ),
    max_size=40,
)


def ask(gate: Gate, linear: tuple[float, ...], angular: tuple[float, ...] = (0, 0, 0), ttl: float = 0.1) -> None:
    gate.command(np.array(linear, float), np.array(angular, float), ttl, age=0.0)


def gate_with(linear: tuple[float, ...], angular: tuple[float, ...] = (0, 0, 0), ttl: float = 0.1) -> Gate:
    gate = Gate(LIMITS)
    ask(gate, linear, angular, ttl)
    return gate


def run(gate: Gate, steps: int) -> np.ndarray:
    """The last twist."""
    return [gate.advance(DT) for _ in range(steps)][-1]


@settings(max_examples=400)
@given(events)
def test_for_any_sequence_the_executed_twist_is_within_every_limit(sequence: list[Command | float | bool]) -> None:
    gate = Gate(LIMITS)
    before = np.zeros(6)
    stopped = False
    for event in sequence:
        if isinstance(event, Command):
            gate.command(np.array(event.linear), np.array(event.angular), event.ttl, event.age, event.valid)
            continue
        if isinstance(event, bool):
            stopped = event
            gate.stop(event, "test")
            continue
        twist = gate.advance(event)
        assert np.isfinite(twist).all()
        for part, limit, acceleration in (
            (slice(0, 3), LIMITS.max_linear, LIMITS.max_linear_acceleration),
            (slice(3, 6), LIMITS.max_angular, LIMITS.max_angular_acceleration),
        ):
            speed = np.linalg.norm(twist[part])
            assert speed <= limit * (1 + ROUNDING)
            assert speed <= np.linalg.norm(before[part]) + acceleration * event + ROUNDING
        if stopped:
            assert not twist.any()
            assert gate.mode == "stopped"
        before = twist


@settings(max_examples=200)
@given(commands(anything), st.lists(st.floats(1e-4, 0.05), min_size=1, max_size=60))
def test_nothing_moves_after_the_ttl(command: Command, steps: list[float]) -> None:
    gate = Gate(LIMITS)
    gate.command(np.array(command.linear), np.array(command.angular), command.ttl, command.age, command.valid)
    passed = 0.0
    for dt in steps:
        twist = gate.advance(dt)
        left = min(command.ttl, LONGEST_TTL) - max(command.age, 0.0)
        if not command.valid or not left > passed + ROUNDING:
            assert not twist.any()
        passed += dt


@settings(max_examples=200)
@given(st.floats(1e-3, LONGEST_TTL), st.lists(st.floats(1e-4, 0.05), min_size=1, max_size=60))
def test_a_command_travels_no_further_than_its_ttl_allows(ttl: float, steps: list[float]) -> None:
    gate = gate_with((0.1, 0.0, 0.0), ttl=ttl)
    travelled = sum(gate.advance(dt)[0] * dt for dt in steps)
    assert travelled <= 0.1 * ttl * (1.0 + ROUNDING) + ROUNDING


@settings(max_examples=200)
@given(commands(ordinary), st.integers(1, 40))
def test_the_direction_of_a_command_is_kept(command: Command, count: int) -> None:
    gate = gate_with(command.linear, command.angular)
    wanted = np.array((*command.linear, *command.angular))
    twists = [gate.advance(DT) for _ in range(count)]
    shares = [float(np.linalg.norm(twist) / max(np.linalg.norm(wanted), 1e-300)) for twist in twists]
    for twist, share in zip(twists, shares, strict=True):
        np.testing.assert_allclose(twist, share * wanted, atol=1e-12)
        assert share <= 1.0 + ROUNDING
    assert all(later >= earlier - ROUNDING for earlier, later in itertools.pairwise(shares))


def test_a_command_within_the_limits_is_reached_exactly() -> None:
    gate = gate_with((0.1, 0.0, 0.05), (0.2, 0.0, 0.0), ttl=0.2)
    np.testing.assert_array_equal(run(gate, 90), (0.1, 0.0, 0.05, 0.2, 0.0, 0.0))
    assert gate.clamped == 0 and gate.mode == "ready" and gate.reason == ""


@pytest.mark.parametrize(
    ("wanted", "at_once"),
    [(0.01, 0.01), (-0.2, -LIMITS.max_linear_acceleration * DT)],
    ids=["slowing down is immediate", "reversing begins at rest"],
)
def test_what_follows_a_fast_command(wanted: float, at_once: float) -> None:
    gate = gate_with((0.2, 0.0, 0.0), ttl=0.2)
    run(gate, 99)
    ask(gate, (wanted, 0.0, 0.0))
    assert gate.advance(DT)[0] == pytest.approx(at_once)


@pytest.mark.parametrize("linear", [(1.0, 0.0, 0.0), (1e308, -1e308, 1e308), (0.2, 0.2, 0.2)])
def test_an_excess_is_clamped_and_counted(linear: tuple[float, ...]) -> None:
    gate = gate_with(linear)
    assert gate.clamped == 1
    for _ in range(49):
        twist = gate.advance(0.01 if gate.mode == "ready" else 0.0)
    assert np.linalg.norm(twist[:3]) <= LIMITS.max_linear * (1 + ROUNDING)


def test_an_excessive_ttl_is_clamped_and_counted() -> None:
    gate = gate_with(FORWARDS, ttl=1e9)
    assert gate.clamped == 1
    assert not run(gate, round(LONGEST_TTL / DT) + 1).any()


@pytest.mark.parametrize(
    ("y", "age", "valid", "late"),
    [
        (0.0, 0.0, False, 0),
        (0.0, 0.11, True, 1),
        (math.nan, 0.0, True, 0),
        (math.inf, 0.0, True, 0),
        (-math.inf, 0.0, True, 0),
    ],
    ids=["invalid", "older than its ttl", "NaN", "infinite", "minus infinite"],
)
def test_what_is_no_command_to_execute_means_stop(y: float, age: float, valid: bool, late: int) -> None:
    gate = gate_with(FORWARDS)
    gate.advance(DT)
    gate.command(np.array((0.1, y, 0.0)), np.zeros(3), 0.1, age, valid)
    assert not gate.advance(DT).any()
    assert (gate.held, gate.late, gate.expired, gate.mode) == (1, late, 0, "holding")


def test_a_silent_controller_is_counted_once() -> None:
    gate = gate_with(FORWARDS, ttl=0.01)
    run(gate, round((0.01 + SILENCE) / DT) - 1)
    assert gate.expired == 0
    run(gate, 200)
    assert gate.expired == 1
    assert gate.mode == "holding" and gate.reason == "no fresh command"


def test_commands_slower_than_their_ttl_are_one_motion() -> None:
    gate = gate_with(FORWARDS, ttl=0.02)
    for _ in range(60):
        run(gate, 16)
        assert gate.mode == "holding"
        ask(gate, FORWARDS, ttl=0.02)
    assert gate.expired == 0


@pytest.mark.parametrize("ttl", [10 * DT, 9.5 * DT], ids=["between two steps", "within a step"])
def test_a_motion_that_is_broken_off_however_shortly_is_counted_once(ttl: float) -> None:
    gate = gate_with(FORWARDS, ttl=ttl)
    run(gate, 9)
    assert gate.held == 0
    run(gate, 2)
    assert (gate.held, gate.expired) == (1, 0)
    run(gate, 200)
    assert gate.held == 1


def test_commands_in_time_and_a_stop_are_no_holding() -> None:
    gate = gate_with(FORWARDS, ttl=10 * DT)
    for speed in (0.1, 0.05, 0.0, 0.1, 0.0):
        ask(gate, (speed, 0.0, 0.0), ttl=10 * DT)
        run(gate, 9 if speed else 50)
    ask(gate, FORWARDS, ttl=10 * DT)
    gate.advance(DT)
    gate.stop(True, "hand on the button")
    run(gate, 50)
    assert gate.held == 0


def test_a_stop_is_latched_until_it_is_released() -> None:
    gate = gate_with(FORWARDS)
    gate.advance(DT)
    gate.stop(True, "hand on the button")
    for _ in range(100):
        ask(gate, FORWARDS)
        assert not gate.advance(DT).any()
    assert gate.mode == "stopped" and "hand on the button" in gate.reason and "tandem resume" in gate.reason
    gate.stop(False, "")
    assert not gate.advance(DT).any()  # only a command after the release moves
    ask(gate, FORWARDS)
    assert gate.advance(DT).any()


@pytest.mark.parametrize("dt", [math.nan, math.inf, -0.001])
def test_a_time_that_is_none_is_refused(dt: float) -> None:
    gate = gate_with(FORWARDS)
    with pytest.raises(ValueError, match="dt is"):
        gate.advance(dt)


@pytest.mark.parametrize("limit", [0.0, -1.0, math.nan, math.inf])
def test_a_gate_has_positive_finite_limits(limit: float) -> None:
    with pytest.raises(ValueError, match="max_angular"):
        GateLimits(0.25, limit, 1.0, 2.0)
