"""The service in simulated time: what silences, broken sensors, stops and a restarted robot lead to."""

from __future__ import annotations

import numpy as np
import pytest

from services.controller.laws import LAWS
from shared.messages import Stop
from shared.topics import STOP
from tests.services.controller.rig import PERIOD, Rig


def moving(**parameters: object) -> Rig:
    """A healthy rig whose tool is on its way to its target."""
    rig = Rig(**parameters).started(offset=(0.3, 0, 0))
    assert rig.twist[0] > 0
    return rig


def fail_sensor(rig: Rig, word: str, duration: float) -> None:
    rig.wrench_valid, rig.wrench_fault, rig.wrench_period = False, word, 0.05
    rig.run(duration)


def mend_sensor(rig: Rig, duration: float = 1.0) -> None:
    rig.wrench_valid, rig.wrench_fault, rig.wrench_period = True, "", PERIOD
    rig.run(duration)


def stop(rig: Rig, active: bool, duration: float, reason: str = "", valid: bool = True) -> None:
    rig.publish(STOP, Stop(active, reason), valid)
    rig.run(duration)


@pytest.mark.parametrize("law", LAWS)
def test_silent_wrench_brakes_within_three_periods_and_recovers_when_only_the_transport_failed(law: str) -> None:
    rig = moving(law=law)
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


@pytest.mark.parametrize("silence", [0.2, 1.0])
def test_state_silence_brakes_and_recovers_with_the_same_target(silence: float) -> None:
    rig = moving()
    rig.ee_on = False
    rig.run(silence)
    assert not rig.twist.any() and "state/ee" in rig.status.reason
    rig.ee_on = True
    rig.run(0.8)
    assert rig.twist[0] > 0 and rig.status.state == "tracking"


@pytest.mark.parametrize("word", ["silent", "stuck", "saturated"])
def test_sensor_failure_over_100_ms_is_latched_until_released(word: str) -> None:
    rig = moving()
    fail_sensor(rig, word, 0.5)
    assert not rig.twist.any() and rig.status.state == "braking"
    mend_sensor(rig, 2.0)
    assert rig.resting and word in rig.status.reason and "tandem resume" in rig.status.reason
    stop(rig, False, 0.5, "checked")
    assert rig.twist[0] > 0 and rig.status.state == "tracking"


@pytest.mark.parametrize(("duration", "robot"), [(0.04, True), (2.0, False)], ids=["short", "the whole robot gone"])
def test_a_sensor_failure_that_is_short_or_the_robots_is_not_latched(duration: float, robot: bool) -> None:
    rig = moving()
    rig.ee_on = robot
    fail_sensor(rig, "silent", duration)
    assert not rig.twist.any()
    rig.ee_on = True
    mend_sensor(rig)
    assert rig.twist[0] > 0


def test_latched_about_100_ms_after_the_last_sample_with_the_timing_of_the_wrench_service() -> None:
    rig = moving()
    onset = rig.stack.scheduler.clock.now_ns()
    rig.wrench_on = False
    rig.run(0.025)
    rig.wrench_on = True
    fail_sensor(rig, "silent", 0.5)
    latched = next(r.arrival_ns for r in rig.statuses if "latched" in r.message.reason)
    assert 0.09 <= (latched - onset) * 1e-9 <= 0.15


@pytest.mark.parametrize("valid", [True, False])
def test_stop_brakes_at_the_next_wrench_until_a_valid_release(valid: bool) -> None:
    rig = moving()
    stop(rig, True, 0.02, "red button", valid)
    assert not rig.twist.any() and rig.status.state == "braking" and "red button" in rig.status.reason
    rig.run(3.0)
    assert rig.resting
    stop(rig, False, 0.5, valid=False)
    assert rig.resting and "red button" in rig.status.reason
    stop(rig, False, 0.1)
    assert rig.twist[0] > 0


def test_an_invalid_release_releases_no_latched_sensor() -> None:
    rig = moving()
    fail_sensor(rig, "stuck", 0.5)
    mend_sensor(rig)
    stop(rig, False, 0.5, valid=False)
    assert rig.resting and "tandem resume" in rig.status.reason
    stop(rig, False, 0.1)
    assert rig.twist[0] > 0


def test_a_restarted_robot_rests_where_it_is_until_a_new_target() -> None:
    rig = moving()
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
    rig = moving()
    rig.restart_robot(0.3)
    for _ in range(4):
        rig.target(offset=(0.3, 0, 0))
        rig.run(0.2)
    assert rig.twist[0] > 0 and rig.status.state == "tracking"
