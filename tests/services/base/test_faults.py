"""The service in simulated time: silences, broken sensors, stops, a restarted robot; and any inputs whatever."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from services.base.base import Base
from services.base.parameters import BaseParameters
from shared import faults
from shared.messages import Enable, EndEffector, ExternalWrench, Header, RobotStatus, Stop
from shared.service import Inputs, Reading
from shared.topics import BASE_ENABLE, STATE_EE, STATE_ROBOT, STOP, WRENCH_EXTERNAL
from tests.services.base.rig import PERIOD, Rig


@pytest.mark.parametrize(("lost", "within"), [("wrench_valid", 0.011), ("wrench_on", 0.041), ("robot_on", 0.111)])
def test_brakes_for_a_fault_and_follows_again_by_itself(lost: str, within: float) -> None:
    rig = Rig().pushed()
    speed = rig.velocity[0]
    setattr(rig, lost, False)
    rig.run(within)
    assert rig.status.state == "braking" and not rig.commands[-1].header.valid
    assert rig.velocity[0] < max(speed, *rig.velocities[:, 0])
    rig.run(2.0)
    assert not rig.velocity.any() and rig.status.state == "braking"
    setattr(rig, lost, True)
    rig.run(0.35)
    assert not rig.velocity.any()
    rig.run(0.6)
    assert rig.velocity[0] > 0.0 and rig.status.state == "following"


def test_an_invalid_wrench_never_drives_the_base() -> None:
    rig = Rig().started()
    rig.wrench_valid = False
    rig.push(fx=9.0)
    rig.run(3.0)
    assert rig.resting


def test_silence_brakes_at_the_acceleration_limit() -> None:
    rig = Rig().pushed()
    rig.wrench_on = False
    rig.run(0.4)
    speeds = rig.velocities[:, 0]
    times = np.array([received.arrival_ns * 1e-9 for received in rig.commands])
    assert np.all(np.diff(speeds) <= 0.0)
    assert np.all(np.diff(speeds) >= -0.7 * np.diff(times) - 1e-9)
    assert speeds[-1] == pytest.approx(speeds[0] - 0.7 * (times[-1] - times[0]))


def test_after_a_fault_that_lasts_it_begins_from_rest() -> None:
    rig = Rig(max_linear_acceleration=0.05).pushed(duration=4.0)
    rig.wrench_on = False
    rig.run(0.3)
    assert rig.velocity[0] > 0.1, "the robot, which ignores invalid commands, is at rest before the ramp is"
    rig.wrench_on = True
    rig.run(0.7)
    first = next(received for received in rig.commands if received.header.valid)
    assert 0.0 < first.message.velocity[0] <= 0.05 * 0.011


def fail_sensor(rig: Rig, word: str, duration: float) -> None:
    rig.wrench_valid, rig.wrench_fault, rig.period = False, word, lambda: 0.05
    rig.run(duration)


def mend_sensor(rig: Rig, duration: float = 1.5) -> None:
    rig.wrench_valid, rig.wrench_fault, rig.period = True, "", lambda: PERIOD
    rig.run(duration)


@pytest.mark.parametrize("word", ["silent", "stuck", "saturated"])
def test_sensor_failure_over_100_ms_is_latched_until_released(word: str) -> None:
    rig = Rig().pushed()
    fail_sensor(rig, word, 1.5)
    mend_sensor(rig)
    assert not rig.velocity.any() and rig.status.state == "braking"
    assert word in rig.base.notes() and "tandem resume" in rig.base.notes()
    rig.stop(False)
    rig.run(0.2)
    assert rig.velocity[0] > 0.0 and rig.status.state == "following" and rig.base.notes() == ""


def test_a_short_sensor_failure_is_not_latched() -> None:
    rig = Rig().pushed()
    fail_sensor(rig, "silent", 0.04)
    mend_sensor(rig)
    assert rig.velocity[0] > 0.0


HALTS: dict[str, tuple[Callable[[Rig], None], str, Callable[[Rig], None]]] = {
    "stop": (lambda rig: rig.stop(True), "red button", lambda rig: rig.stop(False)),
    "invalid stop": (lambda rig: rig.stop(True, valid=False), "red button", lambda rig: rig.stop(False)),
    # A stop whose message never came here.
    "robot": (lambda rig: rig.say_robot("stopped"), "robot is stopped: by hand", lambda rig: rig.say_robot("ready")),
}


@pytest.mark.parametrize("name", HALTS)
def test_a_stop_brakes_at_the_next_wrench_until_it_is_released(name: str) -> None:
    halt, words, release = HALTS[name]
    rig = Rig().pushed()
    speed = rig.velocity[0]
    halt(rig)
    rig.run(0.02)
    assert rig.velocity[0] == pytest.approx(speed - 0.7 * 0.02, abs=0.7 * 0.011)
    assert rig.status.state == "braking" and words in rig.base.notes()
    rig.run(3.0)
    assert not rig.velocity.any() and rig.status.state == "off"
    rig.stop(False, valid=False)
    rig.run(1.0)
    assert rig.resting and words in rig.base.notes(), "an invalid release releases nothing"
    release(rig)
    rig.run(0.1)
    assert rig.velocity[0] > 0.0


def test_a_stop_from_before_its_start_is_heard_from_the_robot() -> None:
    rig = Rig()
    rig.mode = "stopped"
    rig.push(fx=9.0)
    rig.run(2.0)
    assert rig.resting and rig.status.state == "off" and "robot is stopped: by hand" in rig.base.notes()
    rig.say_robot("ready")
    rig.run(0.1)
    assert rig.velocity[0] > 0.0


def test_a_restarted_robot_rests_until_it_is_enabled_anew() -> None:
    rig = Rig().pushed()
    rig.enable_on = False
    rig.restart_robot(0.1)
    rig.enable(True)  # still meant for the robot as it was
    rig.run(0.99)
    assert not rig.velocities[-30:].any() and rig.status.state != "following"
    rig.run(2.0)
    assert rig.resting
    rig.enable(True)
    rig.run(0.1)
    assert rig.velocity[0] > 0.0


def test_a_restarted_robot_goes_on_under_a_task_that_keeps_enabling() -> None:
    rig = Rig().pushed()
    rig.restart_robot(0.3)
    rig.run(3.0)
    assert rig.velocity[0] > 0.0 and rig.status.state == "following"


def test_absurd_but_finite_numbers_crash_nothing() -> None:
    rig = Rig().pushed()
    for wrench in (np.full(6, 1e300), np.full(6, -1.7e308)):
        rig.wrench, rig.position = wrench, (1e10, 1e10, 0.0)
        rig.run(0.3)
        assert np.isfinite(rig.velocities).all() and np.abs(rig.velocities).max() <= 0.4
    assert rig.status.state == "braking" and "not finite" in rig.runner.fault.text
    rig.run(1.0)
    assert not rig.velocity.any(), "a step that fails every time slows down all the same"


finite = st.floats(allow_nan=False, allow_infinity=False)
numbers = finite | st.floats(-30, 30)
three = st.tuples(numbers, numbers, numbers)
bounds = st.tuples(*[st.floats(0, 3) | st.floats(0, 1e308)] * 6)
FAULTS = (
    faults.invalid(WRENCH_EXTERNAL.key, "stuck"),
    faults.silent(STATE_EE.key, "the robot", 0.2, 0.1),
    faults.stalled(0.2, 0.05),
)
actions = st.tuples(
    st.sampled_from(("step", "step", "step", "brake")),
    st.floats(0.0, 0.1),
    st.tuples(three, three, bounds, three),
    st.tuples(st.booleans(), st.booleans(), st.floats(0.0, 2.0), st.booleans(), st.booleans()),
    st.sampled_from(FAULTS),
)


def reading(message, age: float = 0.0, valid: bool = True) -> Reading:
    return Reading(message, Header(0, 1, 0, valid), age, True)


def inputs(vectors, flags, base_type: str) -> Inputs:
    force, torque, bound, position = vectors
    enabled, valid, age, stopped, engaged = flags
    zero = np.zeros(3)
    mode = "stopped" if stopped else "ready"
    return Inputs(
        {
            WRENCH_EXTERNAL.key: reading(ExternalWrench(force, torque, bound, "tare", "")),
            STATE_EE.key: reading(EndEffector(position, (0, 0, 0, 1), zero, zero)),
            STATE_ROBOT.key: reading(RobotStatus(mode, "", base_type, False, 0.3, 1.0, (0.35, 0.25, 0.3))),
            BASE_ENABLE.key: reading(Enable(enabled), age, valid),
            STOP.key: reading(Stop(engaged)),
        }
    )


@pytest.mark.parametrize("base_type", ["omni", "differential"])
@given(st.lists(actions, min_size=1, max_size=25))
def test_any_inputs_give_finite_commands_within_the_limits_of_speed_and_acceleration(base_type: str, history) -> None:
    base = Base(BaseParameters())
    before, since = np.zeros(3), 0.0
    for kind, dt, vectors, flags, fault in history:
        since += dt
        outputs = []
        if kind == "step":
            try:
                outputs = list(base.step(inputs(vectors, flags, base_type), dt))
            except ArithmeticError as problem:
                # As the loop does it.
                outputs, kind = list(base.brake(faults.internal(problem), 0.0)), "brake"
        else:
            outputs = list(base.brake(fault, dt))
        command, status = (output.message for output in outputs)
        velocity = command.velocity
        assert np.isfinite(velocity).all() and np.all(np.abs(velocity) <= (0.35, 0.25, 0.3))
        assert base_type == "omni" or (velocity[1] == 0.0 and velocity[0] >= -0.2)
        change = velocity - before
        assert math.hypot(*change[:2]) <= 0.7 * since + 1e-12 and abs(change[2]) <= 2.0 * since + 1e-12
        enabled, valid, age, stopped, engaged = flags
        may_move = kind == "step" and enabled and valid and age <= 1.0 and not stopped and not engaged
        if not may_move:
            assert math.hypot(*velocity[:2]) <= max(0.0, math.hypot(*before[:2]) - 0.7 * since) + 1e-12
            assert abs(velocity[2]) <= max(0.0, abs(before[2]) - 2.0 * since) + 1e-12
            assert status.state != "following"
        before, since = velocity, 0.0
