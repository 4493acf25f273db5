"""The gate as everybody else sees it: through the robot's motion and ``state/robot``."""

from __future__ import annotations

import secrets

import numpy as np
import pytest

from services.sim.robot.arm import DRIVE_LAG
from shared import topics
from shared.messages import Stop, TwistCommand
from shared.wire.client import Client
from tests.services.sim.rig import Rig

DOWN = (0.0, 0.0, -0.1)


@pytest.fixture
def rig() -> Rig:
    return Rig()


def test_without_commands_it_holds_and_says_why(rig: Rig) -> None:
    status = rig.last(topics.STATE_ROBOT)
    assert (status.mode, status.simulated, status.base_type) == ("holding", True, "differential")
    assert status.reason == "no fresh command"
    assert status.max_linear == 0.3 and status.max_angular == 1.0


def test_a_fresh_command_moves_it_and_silence_stops_it(rig: Rig) -> None:
    rig.move(DOWN, 0.3)
    assert rig.last(topics.STATE_ROBOT).mode == "ready"
    assert rig.speed == pytest.approx(0.1, rel=0.02)
    # 20 ms of ttl, then the drives' lag.
    rig.run(0.02 + 6 * DRIVE_LAG)
    assert rig.speed < 1e-3
    rig.run(0.05)
    assert rig.last(topics.STATE_ROBOT).mode == "holding"
    height = rig.height
    rig.run(1.0)
    assert "commands expired: 1" in rig.last(topics.STATE_ROBOT).reason
    assert rig.height == pytest.approx(height, abs=1e-4)


@pytest.mark.parametrize("ttl", [0.004, 0.01, 0.05, 0.2])
def test_a_command_acts_for_its_ttl_to_within_a_physics_step(rig: Rig, ttl: float) -> None:
    start = rig.height
    rig.stack.client.publish(topics.COMMAND_EE_TWIST, TwistCommand((0, 0, -0.1), (0, 0, 0), ttl))
    rig.run(ttl + 0.3)
    # Speeding up from 0 to 0.1 m/s at 5 m/s2 takes 20 ms; the lag delays motion but takes nothing from it.
    rise = min(ttl, 0.02)
    travel = 0.5 * 5.0 * rise**2 + 0.1 * (ttl - rise)
    assert start - rig.height == pytest.approx(travel, abs=0.1 * 0.0021)


def test_a_longer_ttl_than_allowed_is_cut_and_counted(rig: Rig) -> None:
    start = rig.height
    rig.stack.client.publish(topics.COMMAND_EE_TWIST, TwistCommand((0, 0, -0.1), (0, 0, 0), 100.0))
    rig.run(2.0)
    assert start - rig.height < 0.1 * 0.2
    assert "commands clamped: 1" in rig.last(topics.STATE_ROBOT).reason


def test_an_excess_is_clamped_as_a_whole_vector_and_counted(rig: Rig) -> None:
    wanted = np.array((0.4, 0.0, -3.0))
    rig.move(tuple(wanted.tolist()), 0.3)
    linear = rig.last(topics.STATE_EE).linear
    assert np.linalg.norm(linear) == pytest.approx(0.3, rel=0.02)
    assert linear @ wanted / np.linalg.norm(linear) / np.linalg.norm(wanted) > 0.999
    assert "clamped" in rig.last(topics.STATE_ROBOT).reason


def test_speeding_up_is_limited_and_slowing_down_is_not(rig: Rig) -> None:
    rig.move((0, 0, -0.25), 0.02)
    assert rig.speed <= 5.0 * 0.02 * 1.05
    rig.move((0, 0, -0.25), 0.2)
    assert rig.speed == pytest.approx(0.25, rel=0.02)
    rig.move((0, 0, 0), 5 * DRIVE_LAG)
    assert rig.speed < 0.01 * 0.25 + 1e-3


def test_a_second_session_is_refused_and_named_until_the_first_falls_silent(rig: Rig) -> None:
    other = Client(rig.stack.bus, rig.stack.scheduler.clock)
    height = rig.height
    for _ in range(30):
        rig.stack.client.publish(topics.COMMAND_EE_TWIST, TwistCommand((0, 0, 0), (0, 0, 0), 0.02))
        rig.run(0.005)
        other.publish(topics.COMMAND_EE_TWIST, TwistCommand((0, 0, 0.05), (0, 0, 0), 0.02))
        rig.run(0.005)
    rig.run(0.2)
    assert rig.height == pytest.approx(height, abs=1e-4)
    assert "30 from a second session refused" in rig.last(topics.STATE_ROBOT).reason
    for _ in range(10):
        other.publish(topics.COMMAND_EE_TWIST, TwistCommand((0, 0, -0.05), (0, 0, 0), 0.02))
        rig.run(0.01)
    assert rig.height < height - 1e-3


def test_garbage_does_not_move_it_and_is_counted(rig: Rig) -> None:
    height = rig.height
    for _ in range(20):
        rig.stack.bus.publish(topics.COMMAND_EE_TWIST.key, secrets.token_bytes(100))
        rig.run(0.01)
    rig.run(0.2)
    assert rig.height == pytest.approx(height, abs=1e-4)
    assert "20 rejected" in rig.last(topics.STATE_ROBOT).reason


def test_an_invalid_command_means_stop(rig: Rig) -> None:
    rig.move(DOWN, 0.2)
    message = TwistCommand(DOWN, (0, 0, 0), 0.2)
    for _ in range(20):
        rig.stack.client.publish(topics.COMMAND_EE_TWIST, message, valid=False)
        rig.run(0.01)
    assert rig.speed < 1e-3


def test_stop_brakes_within_20_ms_latches_and_is_released_only_by_a_release(rig: Rig) -> None:
    rig.move(DOWN, 0.2)
    rig.stack.client.publish(topics.STOP, Stop(True, "somebody shouted"))
    rig.move(DOWN, 0.02)
    assert rig.simulator.side.mode == "stopped"
    rig.move(DOWN, 0.2)
    assert rig.speed < 1e-3
    status = rig.last(topics.STATE_ROBOT)
    assert status.mode == "stopped"
    assert "somebody shouted" in status.reason
    rig.run(1.0)
    rig.move(DOWN, 0.2)
    assert rig.speed < 1e-3
    rig.stack.client.publish(topics.STOP, Stop(False, ""), valid=False)
    rig.move(DOWN, 0.1)
    assert rig.last(topics.STATE_ROBOT).mode == "stopped"
    rig.stack.client.publish(topics.STOP, Stop(False, ""))
    rig.move(DOWN, 0.3)
    assert rig.speed == pytest.approx(0.1, rel=0.05)


def test_what_the_arm_cannot_do_is_told(rig: Rig) -> None:
    rig.move((0, 0, 0.3), 2.0)
    assert "limit" in rig.last(topics.STATE_ROBOT).reason or "singular" in rig.last(topics.STATE_ROBOT).reason


def test_the_gate_works_in_real_time_whatever_the_real_time_factor() -> None:
    rig = Rig(real_time_factor=2.0)
    start = rig.height
    rig.stack.client.publish(topics.COMMAND_EE_TWIST, TwistCommand((0, 0, -0.1), (0, 0, 0), 0.1))
    rig.run(0.5)
    travel = 0.5 * 5.0 * 0.02**2 / 2 + 0.1 * (0.2 - 0.02)
    assert start - rig.height == pytest.approx(travel, abs=3e-3)
    assert rig.last(topics.SIM_WORLD).time == pytest.approx(2 * rig.stack.now, abs=0.1)
