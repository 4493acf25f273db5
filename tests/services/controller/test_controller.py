"""The service in simulated time: states, start-up, targets and parameters."""

from __future__ import annotations

import numpy as np
import pytest

from shared.messages import ControlTarget, Header
from shared.parameters import Refused
from shared.topics import CONTROL_TARGET
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
        "spring_stiffness", "max_linear", "max_angular", "max_acceleration",
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


def test_a_lower_limit_in_contact_is_reached_without_a_jump() -> None:
    rig = Rig(contact_stiffness=500.0).started(force=25.0)
    rig.wrench = np.array((0.0, 0.0, -15.0, 0.0, 0.0, 0.0))
    rig.run(0.5)
    assert np.abs(rig.twists).max() < 1e-6
    rig.target(force=10.0)
    rig.run(2.0)
    assert rig.twist[2] < 0 and rig.status.margin[2] == pytest.approx(10.0 - 15.0 - ERROR[2])
    assert np.diff(np.abs(rig.twists[:, 2])).max() <= 2.0 * 0.0101


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


def test_shutdown_sends_a_last_zero() -> None:
    rig = Rig().started(offset=(0.2, 0, 0))
    rig.commands.clear()
    rig.runner.close()
    rig.stack.run(0.005)
    assert not rig.twist.any() and rig.status.state == "braking"
