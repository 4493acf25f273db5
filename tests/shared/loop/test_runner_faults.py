"""The service loop on the in-process bus: inputs and steps that fail."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from shared.faults import FaultKind
from shared.messages import TwistCommand
from shared.topics import CONTROL_TARGET, STATE_EE, WRENCH_EXTERNAL, Topic
from tests.shared.loop.rig import Rig, speed
from tests.shared.rig import wrench


@pytest.mark.parametrize(("lost", "topic", "limit"), [("driver", WRENCH_EXTERNAL, 0.03), ("ee", STATE_EE, 0.1)])
def test_a_silent_input_brakes_when_its_age_is_over(rig: Rig, lost: str, topic: Topic, limit: float) -> None:
    getattr(rig, lost).on = False
    silent_since = rig.stack.now
    rig.stack.run(0.5)
    when, kind = rig.first_brake()
    assert kind is FaultKind.SILENT
    assert limit - 0.011 < when - silent_since <= limit + 0.001
    assert all(speed(message) == 0.0 for now, message, _ in rig.commands if now >= when)
    assert rig.service.brakes[0][0].key == topic.key


def test_a_short_silence_is_over_with_the_next_sample(rig: Rig) -> None:
    rig.driver.on = False
    rig.stack.run(0.05)
    rig.driver.on = True
    rig.stack.run(0.03)
    assert rig.service.brakes
    assert rig.runner.fault is None


def test_a_long_silence_is_followed_by_half_a_second_of_healthy_inputs(rig: Rig) -> None:
    rig.driver.on = False
    rig.stack.run(0.5)
    rig.driver.on = True
    rig.service.steps.clear()
    rig.stack.run(0.49)
    assert not rig.service.steps and rig.service.brakes[-1][0].kind is FaultKind.ARMING
    rig.stack.run(0.05)
    assert rig.service.steps


@pytest.mark.parametrize("begins", [True, False], ids=["valid", "invalid"])
def test_a_new_session_of_an_input_is_armed_anew(rig: Rig, begins: bool) -> None:
    rig.driver.on = False
    rig.stack.run(0.04)
    rig.driver.restart()
    rig.driver.on, rig.driver.valid = True, begins
    rig.stack.run(0.03)
    rig.driver.valid = True
    rig.service.steps.clear()
    rig.stack.run(0.45)
    assert not rig.service.steps
    rig.stack.run(0.2)
    assert rig.service.steps


def test_an_invalid_input_brakes_at_once_and_its_word_is_handed_over(rig: Rig) -> None:
    rig.driver.make = lambda: wrench(fault="stuck")
    rig.driver.valid = False
    rig.stack.run(0.011)
    fault = rig.service.brakes[0][0]
    assert fault.kind is FaultKind.INVALID and fault.word == "stuck"
    assert rig.service.calls[-1] == "brake invalid"


def test_the_more_fundamental_fault_is_handed_over(rig: Rig) -> None:
    rig.driver.valid = False
    rig.ee.on = False
    rig.stack.run(0.3)
    assert rig.service.brakes[-1][0].kind is FaultKind.SILENT
    assert rig.service.brakes[-1][0].key == STATE_EE.key


def test_garbage_in_place_of_samples_brakes(rig: Rig) -> None:
    rig.driver.bend = lambda payload: payload[:-3]
    rig.stack.run(0.1)
    assert rig.service.brakes[-1][0].kind is FaultKind.REFUSED
    assert rig.runner.subscriptions[WRENCH_EXTERNAL.key].rejected == 10


def fails(problem: Exception) -> Callable[[], object]:
    def fail() -> None:
        raise problem

    return fail


@pytest.mark.parametrize(
    ("step", "says"),
    [
        *((fails(kind("x")), kind.__name__) for kind in (ZeroDivisionError, ValueError, KeyError, OverflowError)),
        # An output that is not finite cannot be built.
        (lambda: TwistCommand((math.nan, 0.0, 0.0), (0.0, 0.0, 0.0)), "linear is nan"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_an_exception_in_a_step_brakes_in_the_same_tick(rig: Rig, step: Callable[[], object], says: str) -> None:

    def fail(_inputs: object) -> None:
        rig.service.on_step = lambda inputs: None
        step()

    rig.service.on_step = fail
    rig.stack.run(0.0101)
    assert rig.service.calls == ["step", "brake internal"]
    ((_, message, valid),) = rig.commands
    assert speed(message) == 0.0 and not valid
    assert says in rig.service.brakes[0][0].text
    rig.stack.run(0.0101)
    assert rig.service.calls[-1] == "step"


def test_closing_brakes_once_more(rig: Rig) -> None:
    rig.runner.close()
    rig.stack.run(0.0)
    assert rig.service.brakes[-1][0].kind is FaultKind.SHUTDOWN
    assert speed(rig.commands[-1][1]) == 0.0


def test_what_was_refused_is_handed_over_in_words(rig: Rig) -> None:
    rig.stack.bus.publish(CONTROL_TARGET.key, b"garbage")
    rig.stack.run(0.05)
    assert "1 rejected" in rig.service.steps[-1][0].refusals(CONTROL_TARGET)
    assert rig.service.steps[-1][0].refusals(STATE_EE) == ""
