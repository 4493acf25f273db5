"""The service in simulated time: the law at every rate, both kinds of base, enabling, limits and parameters."""

from __future__ import annotations

import math

import numpy as np
import pytest

from shared.messages import Enable
from shared.topics import BASE_ENABLE, BASE_PARAMETERS
from tests.services.base.rig import EXACT, PERIOD, TOOL, Rig


def times_since(rig: Rig, start: float) -> np.ndarray:
    """Time [s] from the last command before the push to each command."""
    return np.array([received.arrival_ns * 1e-9 for received in rig.commands]) - start


def irregular() -> float:
    return float(RANDOM.uniform(0.004, 0.02))


RANDOM = np.random.default_rng(3)
PERIODS = {"30 Hz": lambda: 1 / 30, "100 Hz": lambda: 0.01, "500 Hz": lambda: 0.002, "irregular": irregular}


@pytest.mark.parametrize("base_type", ["omni", "differential"])
@pytest.mark.parametrize("rate", PERIODS)
def test_step_response_to_a_constant_wrench(rate: str, base_type: str) -> None:
    rig = Rig(base_type, **EXACT)
    rig.period = PERIODS[rate]
    rig.started()
    start = rig.commands[-1].arrival_ns * 1e-9
    rig.push(fx=5.0, fy=3.0, tz=-1.0)
    rig.run(2.0)
    time = times_since(rig, start)
    assert time[-1] > 1.9
    x, y, _ = TOOL
    torque = -1.0 + x * 3.0 - y * 5.0
    linear, angular = 1.0 - np.exp(-20.0 / 10.0 * time), 1.0 - np.exp(-10.0 / 2.0 * time)
    sideways = 3.0 / 20.0 if base_type == "omni" else 0.0
    expected = np.column_stack((5.0 / 20.0 * linear, sideways * linear, torque / 10.0 * angular))
    assert rig.velocities == pytest.approx(expected, abs=1e-9)
    assert rig.status.wrench == pytest.approx((5.0, 3.0, torque))
    assert np.array_equal(rig.status.velocity, rig.velocity) and rig.status.state == "following"


def test_one_command_and_one_status_per_wrench_the_command_first() -> None:
    rig = Rig().started()
    rig.run(1.0)
    assert len(rig.commands) == len(rig.statuses) == pytest.approx(1.0 / PERIOD, abs=1)
    for command, status in zip(rig.commands, rig.statuses, strict=True):
        assert command.arrival_ns <= status.arrival_ns
        assert command.header.valid and status.header.valid and command.message.ttl == 0.1


def test_a_differential_base_steers_by_the_lever_of_a_lateral_force() -> None:
    rig = Rig("differential", **EXACT).started()
    rig.push(fy=4.0)
    rig.run(3.0)
    assert rig.velocity == pytest.approx((0.0, 0.0, 0.6 * 4.0 / 10.0), abs=1e-6)


def test_vertical_forces_and_tilting_torques_move_nothing() -> None:
    rig = Rig(**EXACT).started()
    rig.wrench = np.array((0.0, 0.0, -40.0, 5.0, -5.0, 0.0))
    rig.run(1.0)
    assert rig.resting and rig.status.state == "following"


def test_within_the_dead_band_nothing_moves_and_beyond_it_only_the_excess_counts() -> None:
    rig = Rig().started()
    rig.push(fx=0.99, fy=-0.99)
    rig.position = (0.0, 0.0, 1.0)
    rig.run(1.0)
    assert rig.resting
    rig.push(fx=3.0, tz=-2.0)
    rig.run(5.0)
    assert rig.velocity == pytest.approx(((3.0 - 1.0) / 20.0, 0.0, -(2.0 - 1.0) / 10.0), abs=1e-4)


def test_the_dead_band_is_never_below_the_error_bound_carried_over() -> None:
    rig = Rig().started()
    rig.error = np.array((3.0, 2.0, 50.0, 9.0, 9.0, 0.5))
    x, y, _ = TOOL
    about_z = 0.5 + x * 2.0 + abs(y) * 3.0
    rig.push(fx=2.9, tz=about_z + y * 2.9 - 0.01)
    rig.run(1.0)
    assert rig.resting
    rig.push(fx=4.0, fy=2.5, tz=about_z + 1.0 - x * 2.5 + y * 4.0)
    rig.run(5.0)
    assert rig.velocity == pytest.approx((1.0 / 20.0, 0.5 / 20.0, 1.0 / 10.0), abs=1e-4)


def test_own_limits_and_those_of_the_robot_hold() -> None:
    rig = Rig(max_linear=0.3, max_angular=0.25).started()
    rig.push(fx=60.0, fy=80.0, tz=50.0)
    rig.run(5.0)
    assert rig.velocity == pytest.approx((0.3 * 0.6, 0.3 * 0.8, 0.25), abs=1e-3)
    rig.max_base = (0.1, 0.05, 0.02)
    rig.say_robot()
    rig.run(0.05)
    assert np.all(rig.velocities[1:] <= rig.max_base)
    rig.run(1.0)
    assert rig.velocity == pytest.approx(rig.max_base)


def test_it_speeds_up_no_faster_than_allowed_in_the_direction_of_the_force() -> None:
    rig = Rig(max_linear=1.0, max_angular=1.0, **EXACT).started()
    rig.push(fx=60.0, fy=80.0, tz=50.0)
    rig.run(0.2)
    steps = np.diff(rig.velocities, axis=0)
    assert steps == pytest.approx(np.tile((0.7 * 0.006, 0.7 * 0.008, 0.02), (len(steps), 1)), abs=1e-9)


def test_a_differential_base_goes_back_slowly() -> None:
    rig = Rig("differential").started()
    rig.push(fx=-50.0)
    rig.run(4.0)
    assert rig.velocity[0] == pytest.approx(-0.2, abs=1e-3)


def test_a_robot_that_cannot_move_its_base_is_told_of() -> None:
    rig = Rig()
    rig.max_base = (0.0, 0.0, 0.0)
    rig.push(fx=9.0)
    rig.run(1.5)
    assert rig.resting and rig.status.state == "off" and "max_base" in rig.base.notes()


@pytest.mark.parametrize(
    ("base_type", "given", "words"),
    [
        ("omni", {"max_reverse": 0.3}, "no effect on an omni base"),
        ("differential", {"max_reverse": 0.3}, ""),
        ("differential", {"max_reverse": 0.6}, "no effect above max_linear, 0.4"),
        ("omni", {"max_linear": 0.9}, "max_linear is above what the robot allows, 0.5"),
        ("omni", {}, ""),
    ],
)
def test_health_names_parameters_that_have_no_effect_with_this_robot(base_type: str, given: dict, words: str) -> None:
    rig = Rig(base_type, **given)
    rig.max_base = (0.5, 0.5, 2.0)
    rig.run(1.0)
    assert words in rig.base.notes() if words else rig.base.notes() == ""


@pytest.mark.parametrize("missing", [None, "wrench_on", "robot_on", "status_on"])
def test_nothing_moves_before_every_required_input_is_healthy_for_half_a_second(missing: str | None) -> None:
    rig = Rig()
    rig.push(fx=9.0)
    if missing:
        setattr(rig, missing, False)
        rig.run(2.0)
        assert rig.resting and rig.status.state == "off"
        setattr(rig, missing, True)
    rig.run(0.45)
    assert rig.resting and all(received.message.state == "off" for received in rig.statuses)
    assert not any(received.header.valid for received in rig.commands)
    rig.run(0.5)
    assert rig.velocity[0] > 0.0


def falling(rig: Rig) -> bool:
    """Whether every command since the last call of ``run`` is slower, by no more than the acceleration allows."""
    steps = -np.diff(rig.velocities[:, 0])
    return bool(np.all(steps >= 0.0) and np.all(steps <= 0.7 * 0.011)) and bool(steps.any())


def test_without_being_enabled_it_never_moves() -> None:
    rig = Rig()
    rig.enable_on = False
    rig.push(fx=9.0)
    rig.run(3.0)
    assert rig.resting and rig.status.state == "off"


def test_disabled_it_brakes_at_the_limit_and_is_off_then() -> None:
    rig = Rig().pushed()
    speed = rig.velocity[0]
    rig.enable(False)
    rig.run(0.1)
    assert falling(rig) and rig.status.state == "braking"
    assert rig.velocity[0] == pytest.approx(speed - 0.7 * 0.1, abs=0.7 * 0.011)
    rig.run(1.0)
    assert not rig.velocity.any() and rig.status.state == "off"
    assert all(received.header.valid for received in rig.commands), "nothing is wrong"
    rig.enable(True)
    rig.run(0.1)
    assert rig.velocity[0] > 0.0 and rig.status.state == "following"


def test_a_task_silent_for_a_second_has_disabled() -> None:
    rig = Rig().pushed()
    rig.run(0.1)
    rig.enable_on = False
    rig.run(0.7)
    assert rig.status.state == "following"
    rig.run(0.4)
    assert rig.status.state == "braking"
    rig.run(0.1)
    assert falling(rig)
    rig.run(1.0)
    assert not rig.velocity.any() and rig.status.state == "off"
    rig.enable_on = True
    rig.run(0.4)
    assert rig.velocity[0] > 0.0


def test_an_invalid_enable_disables() -> None:
    rig = Rig().pushed()
    rig.publish(BASE_ENABLE, Enable(True), valid=False)
    rig.run(0.05)
    assert rig.status.state == "braking"
    rig.enable_valid = False
    rig.run(2.0)
    assert rig.status.state == "off"


def test_parameters_by_the_names_of_the_contract_and_out_of_range_refused() -> None:
    rig = Rig().started()
    table = rig.set()
    contract = {"mass", "inertia", "damping_linear", "damping_angular", "max_linear", "max_angular"}
    assert contract <= set(table)
    defaults = {"mass": 10.0, "inertia": 2.0, "damping_linear": 20.0, "damping_angular": 10.0}
    assert {name: table[name]["value"] for name in defaults} == defaults
    for name, value, allowed in (
        ("mass", 0.0, "1 to 200 kg"),
        ("max_linear", 1.5, "0.01 to 1 m/s"),
        ("damping_linear", "much", "a finite number"),
        ("bogus", 1.0, "damping_angular"),
    ):
        rig.refuses(allowed, BASE_PARAMETERS, {"set": {name: value}})
        assert rig.set() == table


@pytest.mark.parametrize(
    "change", [{"max_linear": 0.05}, {"damping_linear": 200.0}, {"mass": 1.0}, {"dead_band_force": 20.0}], ids=str
)
def test_changes_while_it_moves_never_jump(change: dict) -> None:
    rig = Rig().pushed()
    before = rig.velocity
    rig.set(**change)
    rig.run(2.0)
    speeds = np.vstack((before, rig.velocities))[:, 0]
    assert np.abs(np.diff(speeds)).max() <= 0.7 * 0.0101
    assert not math.isclose(speeds[-1], speeds[0], abs_tol=1e-3)


def test_shutdown_sends_a_last_zero() -> None:
    rig = Rig().pushed()
    rig.commands.clear()
    rig.runner.close()
    rig.stack.run(0.005)
    assert not rig.velocity.any() and rig.status.state == "braking"
    assert not rig.commands[-1].header.valid
