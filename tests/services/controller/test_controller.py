"""The service in simulated time: states, start-up, targets and parameters."""

from __future__ import annotations

import re

import numpy as np
import pytest

from services.controller.bounds.caps import AXES
from shared.messages import ControlTarget, Header, Stop
from shared.parameters import Refused
from shared.topics import CONTROL_TARGET, STOP
from shared.wire.codec import decode_map, encode, encode_map
from tests.services.controller.rig import ERROR, HOME, PERIOD, Rig


def test_one_command_and_one_status_per_wrench_the_command_first() -> None:
    rig = Rig().started()
    rig.run(1.0)
    assert len(rig.commands) == len(rig.statuses) == pytest.approx(1.0 / PERIOD, abs=1)
    for command, status in zip(rig.commands, rig.statuses, strict=True):
        assert command.arrival_ns <= status.arrival_ns
        assert command.header.valid and status.header.valid
        assert np.array_equal(status.message.twist[:3], command.message.linear)
        assert command.message.ttl == 0.02


def test_no_motion_before_half_a_second_of_health() -> None:
    rig = Rig()
    rig.target(offset=(0.2, 0, 0))
    rig.run(0.45)
    assert rig.resting and all(r.message.state == "waiting" for r in rig.statuses)
    assert not any(r.header.valid for r in rig.commands)
    rig.run(0.3)
    assert rig.twist[0] > 0 and rig.status.state == "tracking"


@pytest.mark.parametrize("missing", ["wrench_on", "ee_on"])
def test_waits_for_each_required_input_in_any_order(missing: str) -> None:
    rig = Rig()
    setattr(rig, missing, False)
    rig.target(offset=(0.2, 0, 0))
    rig.run(2.0)
    assert rig.resting and rig.status.state == "waiting" and "never received" in rig.status.reason
    setattr(rig, missing, True)
    rig.run(0.45)
    assert rig.resting
    rig.run(0.3)
    assert rig.twist[0] > 0


def test_without_a_target_it_waits_and_says_so() -> None:
    rig = Rig()
    rig.run(1.5)
    assert rig.resting and rig.status.state == "waiting" and "control/target" in rig.status.reason
    rig.target(offset=(0.0, 0.1, 0.0))
    rig.run(0.1)
    assert rig.status.state == "tracking" and rig.twist[1] > 0


def test_target_is_reached_and_stays_in_force_when_it_falls_silent() -> None:
    rig = Rig(relaxation_weight=10.0).started(offset=(0.05, 0.0, -0.05))
    rig.run(5.0)
    assert rig.position == pytest.approx((0.55, -0.3, 0.95), abs=1e-3)
    assert rig.status.state == "tracking" and rig.status.lyapunov < 1e-5


def test_a_bad_target_is_refused_by_name_and_the_last_one_stays() -> None:
    rig = Rig().started(offset=(0.1, 0.0, 0.0))
    rig.stack.bus.publish(CONTROL_TARGET.key, b"\x81\xa3seq\x01")
    other = ControlTarget(HOME - 0.1, (0, 0, 0, 1), (8.0,) * 3, (3.0,) * 3)
    message = decode_map(encode(other, Header(99, 1, rig.stack.scheduler.clock.now_ns(), True)))
    rig.stack.bus.publish(CONTROL_TARGET.key, encode_map({**message, "force_limit": [-3.0, 10.0, 10.0]}))
    rig.run(0.2)
    assert rig.twist[0] > 0 and rig.status.margin[0] == pytest.approx(10.0 - ERROR[0])
    assert "force_limit" in rig.status.reason and "-3" in rig.status.reason
    assert "force_limit" in rig.controller.notes()
    rig.target(offset=(0.0, 0.0, 0.0))
    rig.run(0.1)
    assert rig.status.reason == "" and rig.controller.notes() == ""


def test_wrench_within_an_agreed_nominal_is_no_load() -> None:
    rig = Rig().started(nominal_force=(0.0, 0.0, -9.0))
    rig.wrench = np.array((0.0, 0.0, -9.0, 0.0, 0.0, 0.0))
    rig.run(0.5)
    assert rig.status.margin == pytest.approx([9.8, 9.8, 9.8, 2.98, 2.98, 2.98])
    assert np.abs(rig.twists).max() < 1e-6


def test_overload_yields_and_says_on_which_side() -> None:
    rig = Rig().started()
    rig.wrench = np.array((12.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    rig.run(0.2)
    assert rig.status.state == "yielding" and rig.twist[0] > 0
    assert rig.status.active[0] == 1 and rig.status.margin[0] == pytest.approx(10.0 - 12.0 - 0.2)


def test_limits_too_close_to_the_error_brake_with_the_remedy() -> None:
    rig = Rig().started(offset=(0.2, 0, 0), torque=0.05)
    assert rig.resting and rig.status.state == "braking"
    assert "0.05 Nm about x" in rig.status.reason and "tare" in rig.status.reason


@pytest.mark.parametrize(
    ("name", "value", "allowed"),
    [
        ("period", 0.5, "0.001 to 0.2 s"),
        ("yield_start", 1.2, "0.5 to 1"),
        ("law", "pid", "certified"),
        ("contact_reach", [1.0, 1.0], "contact_reach"),
        ("barrier_rate", [1.0] * 5 + [-1.0], "0.0001 to 1000"),
        ("bogus", 1.0, "contact_stiffness"),
    ],
)
def test_parameters_out_of_range_change_nothing(name: str, value: object, allowed: str) -> None:
    rig = Rig().started()
    before = rig.ask()["parameters"]
    with pytest.raises(Refused, match=allowed):
        rig.ask(**{name: value})
    assert rig.ask()["parameters"] == before


def test_parameters_by_the_names_of_the_contract() -> None:
    names = {
        "law", "lyapunov_rate", "relaxation_weight", "barrier_rate", "contact_stiffness", "contact_reach",
        "contact_friction", "zones", "reserve", "yield_start", "period", "delay", "lag", "payload_mass",
        "spring_stiffness", "max_linear", "max_angular", "max_acceleration", "max_retreat_acceleration",
    }  # fmt: skip
    table = Rig().ask()["parameters"]
    assert set(table) == names
    assert all({"value", "unit", "min", "max", "doc"} <= set(row) for row in table.values())


@pytest.mark.parametrize(
    "change",
    [
        {"law": "paper"},
        {"law": "stiffness"},
        {"yield_start": 0.8},
        {"contact_stiffness": 50.0},
        {"max_linear": 0.5},
        {"relaxation_weight": 5.0},
        {"delay": 0.05},
        {"period": 0.03},
    ],
)
def test_changes_in_contact_never_jump(change: dict) -> None:
    rig = Rig(contact_stiffness=5000.0).started(offset=(0.5, 0, 0))
    rig.wrench = np.array((-7.0, 2.0, 0.0, 0.3, 0.0, 0.0))
    rig.run(0.5)
    rig.ask(**change)
    before = rig.twist
    rig.run(1.0)
    speeds = np.abs(np.vstack((before, rig.twists)))
    gains = np.diff(speeds, axis=0).max(axis=0)
    assert np.all(gains <= np.array((2.0,) * 3 + (2.5,) * 3) * 0.0101), gains


@pytest.mark.parametrize("yield_start", [1.0, 0.8])
def test_a_lower_limit_in_contact_is_reached_without_a_jump(yield_start: float) -> None:
    rig = Rig(contact_stiffness=500.0, yield_start=yield_start).started(force=25.0)
    rig.wrench = np.array((0.0, 0.0, -15.0, 0.0, 0.0, 0.0))
    rig.run(0.5)
    assert np.abs(rig.twists).max() < 1e-6 and rig.status.reason == ""
    rig.target(force=10.0)
    rig.run(2.0)
    assert rig.twist[2] < 0 and np.diff(np.abs(rig.twists[:, 2])).max() <= 2.0 * 0.0101
    in_force = rig.status.limit
    assert np.array_equal(in_force[[0, 1, 3, 4, 5]], [10.0, 10.0, 3.0, 3.0, 3.0]) and 15.2 < in_force[2] < 17.0
    assert rig.status.margin[2] == pytest.approx(in_force[2] - 15.0 - ERROR[2])
    assert re.match(r"limit z: 16\.\d N in force, 10 wished; .* \(-15 N\)", rig.status.reason)
    rig.wrench[2] = -6.0
    rig.run(0.2)
    assert rig.status.limit[2] == 10.0 and rig.status.reason == ""


def test_with_nothing_touching_limits_and_nominal_wrench_are_in_force_with_the_next_sample() -> None:
    rig = Rig(yield_start=0.8).started(force=25.0, torque=10.0)
    rig.target(force=10.0, torque=0.5, nominal_force=(0.0, 0.0, -3.0))
    rig.run(1.5 * PERIOD)
    assert np.array_equal(rig.status.limit, [10.0] * 3 + [0.5] * 3) and rig.status.reason == ""
    assert np.array_equal(rig.status.nominal, (0.0, 0.0, -3.0, 0.0, 0.0, 0.0))
    assert rig.status.margin == pytest.approx(rig.status.limit - np.abs(rig.status.nominal) - ERROR)


def test_without_a_target_no_limits_are_stated() -> None:
    rig = Rig()
    rig.run(1.0)
    assert not (rig.status.limit.any() or rig.status.nominal.any() or rig.status.margin.any())


def test_a_limit_lowered_during_a_stop_is_not_said_to_be_in_force_before_it_is() -> None:
    rig = Rig().started(force=25.0)
    rig.wrench = np.array((0.0, 0.0, -15.0, 0.0, 0.0, 0.0))
    rig.publish(STOP, Stop(True, "here"))
    rig.target(force=10.0)
    rig.run(0.3)
    assert rig.status.limit[2] == 25.0 and "stop" in rig.status.reason
    rig.publish(STOP, Stop(False, ""))
    rig.run(0.3)
    assert 15.2 < rig.status.limit[2] < 17.0


@pytest.mark.parametrize("yield_start", [1.0, 0.8])
@pytest.mark.parametrize("axis", range(6))
def test_an_error_that_grows_until_a_limit_cannot_be_kept_is_said_and_then_brakes(
    yield_start: float, axis: int
) -> None:
    """As the bound of an ageing zero does: never tracking silently, and on with a smaller one."""
    rig = Rig(yield_start=yield_start).started(offset=(0.2, 0.1, 0.1), force=10.0, torque=1.0)
    name, limit = AXES[axis], (10.0, 1.0)[axis // 3]
    assert rig.status.state == "tracking" and rig.status.reason == ""
    states = []
    for share in np.arange(0.05, 0.4, 0.01):
        rig.error = np.where(np.arange(6) == axis, share * limit, ERROR)
        rig.run(0.05)
        states.append((rig.status.state, rig.status.reason))
        assert rig.status.state == ("tracking" if share < 1 / 3 else "braking")
        assert (name in rig.status.reason and "tare" in rig.status.reason) or share < 0.25
    assert rig.resting and f"limit {limit:g} " in rig.status.reason
    rig.error = ERROR
    rig.run(0.1)
    assert rig.status.state == "tracking" and rig.status.reason == "" and rig.twist.any()


def test_absurd_but_finite_numbers_brake_and_crash_nothing() -> None:
    rig = Rig().started(offset=(0.2, 0, 0))
    for wrench in (np.full(6, 1e300), np.full(6, -1e155), np.array((0, 0, 0, 1e308, 0, 0))):
        rig.wrench = wrench
        with np.errstate(all="ignore"):
            rig.run(0.05)
        assert np.isfinite(rig.twists).all() and np.abs(rig.twists).max() <= 0.5
    rig.target(nominal_force=(-1.7e308, 0.0, 0.0))
    rig.wrench = np.array((1.7e308, 0, 0, 0, 0, 0))
    with np.errstate(all="ignore"):
        rig.run(0.05)
    assert not rig.twist.any() and rig.status.state == "braking"
    rig.target()
    rig.wrench = np.zeros(6)
    rig.run(0.3)
    assert rig.status.state == "tracking"


def test_a_failed_quadratic_program_shows_in_status_and_health() -> None:
    rig = Rig().started(offset=(0.2, 0, 0))
    qp = rig.controller.law.qp
    qp._minimise = lambda: (None, qp.cost)
    rig.run(0.1)
    assert rig.resting and rig.status.state == "braking" and "quadratic program" in rig.status.reason
    assert "rows" in rig.controller.notes()
    del qp._minimise
    rig.run(0.2)
    assert rig.twist[0] > 0 and rig.status.state == "tracking"
    rig.run(11.0)
    assert rig.controller.notes() == ""


def test_what_gives_way_without_a_solver_says_that_it_moves() -> None:
    rig = Rig(yield_start=0.8).started()
    rig.wrench = np.array((0.0, 0.0, -8.3, 0.0, 0.0, 0.0))
    qp = rig.controller.law.qp
    qp._minimise = lambda: (None, qp.cost)
    rig.run(0.3)
    assert rig.twist[2] < 0 and rig.status.state == "yielding" and "quadratic program" in rig.status.reason


def test_health_names_what_was_set_without_an_effect() -> None:
    rig = Rig(barrier_rate=[2.0] * 6, law="certified", yield_start=0.8)
    assert rig.controller.notes() == "without effect under law certified: barrier_rate"
    rig.ask(law="paper")
    assert rig.controller.notes() == "without effect under law paper: yield_start"
    assert Rig(law="stiffness").controller.notes() == ""


def test_samples_that_come_more_rarely_than_commands_last_are_named() -> None:
    rig = Rig(period=0.02).started()
    assert rig.controller.notes() == ""
    rig.wrench_period = 0.03
    rig.run(10.0)
    assert "ms, period is 20 ms: each command ends before the next" in rig.controller.notes()
    rig.ask(period=0.04)
    assert rig.controller.notes() == ""


def test_contacts_declared_so_stiff_that_nothing_moves_are_named() -> None:
    rig = Rig(contact_stiffness=1e7).started(offset=(0.2, 0, 0))
    assert rig.status.state == "tracking" and "no motion" in rig.status.reason and "stiff" in rig.status.reason


def test_a_payload_whose_inertia_swallows_the_limit_is_named() -> None:
    rig = Rig(payload_mass=5.0).started(offset=(0.2, 0, 0))
    assert rig.resting and rig.status.state == "braking" and "payload_mass x max_acceleration" in rig.status.reason


def test_shutdown_sends_a_last_zero() -> None:
    rig = Rig().started(offset=(0.2, 0, 0))
    rig.commands.clear()
    rig.runner.close()
    rig.stack.run(0.005)
    assert not rig.twist.any() and rig.status.state == "braking"
