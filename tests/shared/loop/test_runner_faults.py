"""The service loop on the in-process bus: inputs and steps that fail."""

from __future__ import annotations

import pytest

from shared.faults import FaultKind
from shared.messages import TwistCommand
from shared.topics import (
    CONTROL_TARGET,
    STATE_EE,
    WRENCH_EXTERNAL,
    Topic,
)
from tests.shared.rig import speed, wrench
from tests.shared.runner_rig import Rig


@pytest.mark.parametrize(("topic", "limit"), [(WRENCH_EXTERNAL, 0.03), (STATE_EE, 0.1)])
def test_a_silent_input_brakes_when_its_age_is_over(topic: Topic, limit: float) -> None:
    rig = Rig()
    inputs = rig.working()
    lost = next(
        source for source, key in zip(inputs, (WRENCH_EXTERNAL, STATE_EE), strict=True) if key == topic
    )
    lost.on = False
    silent_since = rig.stack.now
    rig.stack.run(0.5)
    when, kind = rig.first_brake()
    assert kind is FaultKind.SILENT
    assert limit - 0.011 < when - silent_since <= limit + 0.001
    assert all(speed(message) == 0.0 for now, message, _ in rig.commands if now >= when)
    assert rig.service.brakes[0][0].key == topic.key


def test_a_short_silence_is_over_with_the_next_sample() -> None:
    rig = Rig()
    driver, _ = rig.working()
    driver.on = False
    rig.stack.run(0.05)
    driver.on = True
    rig.stack.run(0.03)
    assert rig.service.brakes
    assert rig.runner.fault is None


def test_a_long_silence_is_followed_by_half_a_second_of_healthy_inputs() -> None:
    rig = Rig()
    driver, _ = rig.working()
    driver.on = False
    rig.stack.run(0.5)
    driver.on = True
    rig.service.steps.clear()
    rig.stack.run(0.49)
    assert not rig.service.steps and rig.service.brakes[-1][0].kind is FaultKind.ARMING
    rig.stack.run(0.05)
    assert rig.service.steps


def test_a_new_session_of_an_input_is_armed_anew() -> None:
    rig = Rig()
    driver, _ = rig.working()
    driver.on = False
    rig.stack.run(0.04)
    driver.restart()
    driver.on = True
    rig.service.steps.clear()
    rig.stack.run(0.45)
    assert not rig.service.steps
    rig.stack.run(0.2)
    assert rig.service.steps


def test_a_new_session_that_begins_invalid_is_armed_anew_too() -> None:
    rig = Rig()
    driver, _ = rig.working()
    driver.on = False
    rig.stack.run(0.04)
    driver.restart()
    driver.on, driver.valid = True, False
    rig.stack.run(0.03)
    driver.valid = True
    rig.service.steps.clear()
    rig.stack.run(0.45)
    assert not rig.service.steps


def test_an_invalid_input_brakes_at_once_and_its_word_is_handed_over() -> None:
    rig = Rig()
    driver, _ = rig.working()
    driver.make = lambda: wrench(fault="stuck")
    driver.valid = False
    rig.stack.run(0.011)
    fault = rig.service.brakes[0][0]
    assert fault.kind is FaultKind.INVALID and fault.word == "stuck"
    assert rig.service.calls[-1] == "brake invalid"


def test_the_more_fundamental_fault_is_handed_over() -> None:
    rig = Rig()
    driver, ee = rig.working()
    driver.valid = False
    ee.on = False
    rig.stack.run(0.3)
    assert rig.service.brakes[-1][0].kind is FaultKind.SILENT
    assert rig.service.brakes[-1][0].key == STATE_EE.key


def test_garbage_in_place_of_samples_brakes() -> None:
    rig = Rig()
    driver, _ = rig.working()
    driver.bend = lambda payload: payload[:-3]
    rig.stack.run(0.1)
    assert rig.service.brakes[-1][0].kind is FaultKind.REFUSED
    assert rig.runner.subscriptions[WRENCH_EXTERNAL.key].rejected == 10


@pytest.mark.parametrize(
    "problem", [ZeroDivisionError("x"), ValueError("NaN"), KeyError("x"), OverflowError()]
)
def test_an_exception_in_a_step_brakes_in_the_same_tick(problem: Exception) -> None:
    rig = Rig()
    rig.working()

    def fail(_inputs: object) -> None:
        rig.service.on_step = lambda inputs: None
        raise problem

    rig.service.on_step = fail
    rig.stack.run(0.0101)
    assert rig.service.calls == ["step", "brake internal"]
    assert len(rig.commands) == 1
    _, message, valid = rig.commands[0]
    assert speed(message) == 0.0 and not valid
    assert type(problem).__name__ in rig.service.brakes[0][0].text
    rig.stack.run(0.0101)
    assert rig.service.calls[-1] == "step"


def test_an_output_that_is_not_finite_cannot_be_built_and_brakes() -> None:
    rig = Rig()
    rig.working()

    def fail(_inputs: object) -> None:
        TwistCommand((float("nan"), 0.0, 0.0), (0.0, 0.0, 0.0))

    rig.service.on_step = fail
    rig.stack.run(0.0101)
    assert rig.service.brakes[0][0].kind is FaultKind.INTERNAL
    assert "linear is nan" in rig.service.brakes[0][0].text


def test_closing_brakes_once_more() -> None:
    rig = Rig()
    rig.working()
    rig.runner.close()
    rig.stack.run(0.0)
    assert rig.service.brakes[-1][0].kind is FaultKind.SHUTDOWN
    assert speed(rig.commands[-1][1]) == 0.0


def test_what_was_refused_is_handed_over_in_words() -> None:
    rig = Rig()
    rig.working()
    rig.stack.bus.publish(CONTROL_TARGET.key, b"garbage")
    rig.stack.run(0.05)
    assert "1 rejected" in rig.service.steps[-1][0].refusals(CONTROL_TARGET)
    assert rig.service.steps[-1][0].refusals(STATE_EE) == ""
