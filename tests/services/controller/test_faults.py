"""The service in simulated time: what silences, broken sensors, stops and a restarted robot lead to."""

from __future__ import annotations

import numpy as np
import pytest

from shared.messages import Stop
from shared.topics import STOP
from tests.services.controller.rig import PERIOD, Rig


@pytest.mark.parametrize("law", ["certified", "paper", "stiffness"])
def test_silent_wrench_brakes_within_three_periods_and_recovers_when_only_the_transport_failed(
    law: str,
) -> None:
    rig = Rig(law=law).started(offset=(0.3, 0, 0))
    assert rig.twist[0] > 0
    rig.wrench_on = False
    rig.run(0.035)
    assert not rig.twist.any() and rig.status.state == "braking" and "wrench/external" in rig.status.reason
    rig.run(2.0)
    assert rig.resting and len(rig.commands) == pytest.approx(40, abs=2)
    rig.wrench_on = True
    rig.run(0.45)
    assert rig.resting
    rig.run(0.3)
    assert rig.twist[0] > 0


def test_state_silence_brakes_and_recovers() -> None:
    rig = Rig().started(offset=(0.3, 0, 0))
    rig.ee_on = False
    rig.run(0.2)
    assert not rig.twist.any() and "state/ee" in rig.status.reason
    rig.ee_on = True
    rig.run(0.8)
    assert rig.twist[0] > 0


def fail_sensor(rig: Rig, word: str, duration: float) -> None:
    rig.wrench_valid, rig.wrench_fault, rig.wrench_period = False, word, 0.05
    rig.run(duration)


def mend_sensor(rig: Rig, duration: float = 1.0) -> None:
    rig.wrench_valid, rig.wrench_fault, rig.wrench_period = True, "", PERIOD
    rig.run(duration)


@pytest.mark.parametrize("word", ["silent", "stuck", "saturated"])
def test_sensor_failure_over_100_ms_is_latched_until_released(word: str) -> None:
    rig = Rig().started(offset=(0.3, 0, 0))
    fail_sensor(rig, word, 0.5)
    assert not rig.twist.any() and rig.status.state == "braking"
    mend_sensor(rig, 2.0)
    assert rig.resting and word in rig.status.reason and "tandem resume" in rig.status.reason
    rig.publish(STOP, Stop(False, "checked"))
    rig.run(0.5)
    assert rig.twist[0] > 0 and rig.status.state == "tracking"


def test_a_short_sensor_failure_is_not_latched() -> None:
    rig = Rig().started(offset=(0.3, 0, 0))
    fail_sensor(rig, "silent", 0.04)
    assert not rig.twist.any()
    mend_sensor(rig)
    assert rig.twist[0] > 0


def test_a_robot_that_is_gone_altogether_latches_nothing() -> None:
    rig = Rig().started(offset=(0.3, 0, 0))
    rig.ee_on = False
    fail_sensor(rig, "silent", 2.0)
    rig.ee_on = True
    mend_sensor(rig)
    assert rig.twist[0] > 0


def test_latched_about_100_ms_after_the_last_sample_with_the_timing_of_the_wrench_service() -> None:
    rig = Rig().started(offset=(0.3, 0, 0))
    onset = rig.stack.scheduler.clock.now_ns()
    rig.wrench_on = False
    rig.run(0.025)
    rig.wrench_on = True
    fail_sensor(rig, "silent", 0.5)
    latched = next(r.arrival_ns for r in rig.statuses if "latched" in r.message.reason)
    assert 0.09 <= (latched - onset) * 1e-9 <= 0.15


def test_stop_brakes_at_the_next_wrench_until_released() -> None:
    rig = Rig().started(offset=(0.3, 0, 0))
    rig.publish(STOP, Stop(True, "red button"))
    rig.run(0.02)
    assert not rig.twist.any() and rig.status.state == "braking" and "red button" in rig.status.reason
    rig.run(3.0)
    assert rig.resting
    rig.publish(STOP, Stop(False))
    rig.run(0.1)
    assert rig.twist[0] > 0


def test_an_invalid_stop_stops_but_an_invalid_release_releases_nothing() -> None:
    rig = Rig().started(offset=(0.3, 0, 0))
    rig.publish(STOP, Stop(True, "red button"), valid=False)
    rig.run(0.02)
    assert not rig.twist.any() and "red button" in rig.status.reason
    rig.publish(STOP, Stop(False), valid=False)
    rig.run(0.5)
    assert rig.resting and "red button" in rig.status.reason
    rig.publish(STOP, Stop(False))
    rig.run(0.1)
    assert rig.twist[0] > 0
    fail_sensor(rig, "stuck", 0.5)
    mend_sensor(rig)
    rig.publish(STOP, Stop(False), valid=False)
    rig.run(0.5)
    assert rig.resting and "tandem resume" in rig.status.reason
    rig.publish(STOP, Stop(False))
    rig.run(0.1)
    assert rig.twist[0] > 0


def test_a_restarted_robot_rests_where_it_is_until_a_new_target() -> None:
    rig = Rig().started(offset=(0.3, 0, 0))
    assert rig.twist[0] > 0
    rig.restart_robot(0.3, position=(0.0, 0.5, 0.7))
    rig.target(offset=(0.2, 0, 0))  # still meant for the robot as it was
    rig.run(2.0)
    assert rig.resting and rig.status.state == "waiting"
    assert rig.status.reason == "robot restarted, a new control/target is needed"
    assert np.array_equal(rig.position, (0.0, 0.5, 0.7)) and not rig.status.margin.any()
    rig.target(offset=(0.1, 0, 0))
    rig.run(0.5)
    assert rig.twist[0] > 0 and rig.status.state == "tracking"
    assert np.diff(np.abs(rig.twists), axis=0).max() <= 2.0 * 0.0101


def test_a_restarted_robot_goes_on_at_once_under_a_task_that_repeats_its_target() -> None:
    rig = Rig().started(offset=(0.3, 0, 0))
    rig.restart_robot(0.3)
    for _ in range(4):
        rig.target(offset=(0.3, 0, 0))
        rig.run(0.2)
    assert rig.twist[0] > 0 and rig.status.state == "tracking"


def test_a_robot_that_was_only_silent_keeps_its_target() -> None:
    rig = Rig().started(offset=(0.3, 0, 0))
    rig.ee_on = False
    rig.run(1.0)
    rig.ee_on = True
    rig.run(1.0)
    assert rig.twist[0] > 0 and rig.status.state == "tracking"
