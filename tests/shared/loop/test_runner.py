"""The service loop on the in-process bus: when it steps, when it brakes, and what it tells."""

from __future__ import annotations

import itertools

import pytest

from shared.faults import FaultKind
from shared.loop.stack import Stack
from shared.service import LONGEST_DT, Reading
from shared.topics import COMMAND_EE_TWIST, CONTROL_TARGET, SENSOR_FT, STATE_EE, STATE_JOINTS, WRENCH_EXTERNAL
from tests.shared.loop.rig import Recorder, Rig, Source
from tests.shared.rig import ft_sample, target, tool, wrench


def test_without_inputs_it_brakes_and_waits() -> None:
    rig = Rig()
    rig.stack.run(1.0)
    assert not rig.service.steps
    fault = rig.service.brakes[-1][0]
    assert fault.kind is FaultKind.NEVER_SEEN and fault.waiting and "Is wrench running?" in fault.text
    gaps = [b - a for (a, _, _), (b, _, _) in itertools.pairwise(rig.commands)]
    assert max(gaps) <= 0.05 + 1e-6  # the contract's 20 Hz
    assert not any(valid for _, _, valid in rig.commands)


@pytest.mark.parametrize("order", list(itertools.permutations(("service", "wrench", "ee"))))
def test_it_moves_only_after_half_a_second_of_healthy_inputs_in_any_start_order(order: tuple[str, ...]) -> None:
    stack = Stack()
    service = Recorder()
    healthy_at = 0.0
    for part in order:
        stack.run(0.37)
        if part == "service":
            stack.add(service)
        elif part == "wrench":
            Source(stack, WRENCH_EXTERNAL, wrench)
        else:
            Source(stack, STATE_EE, tool)
        assert not service.steps
        healthy_at = stack.now
    stack.run(0.495)
    assert not service.steps
    assert service.brakes[-1][0].kind is FaultKind.ARMING
    stack.run(0.05)
    assert service.steps
    assert stack.now - healthy_at < 0.6


def test_one_step_per_new_driving_sample_and_none_without(rig: Rig) -> None:
    rig.stack.run(1.0)
    assert rig.service.calls == ["step"] * 100
    assert {round(dt, 9) for _, dt in rig.service.steps} == {0.01}
    assert all(valid for _, _, valid in rig.commands)


def test_a_slow_driver_is_stepped_by_its_samples_alone() -> None:
    """The watchdog of a fast input fires between the samples of a slow driver: it must not cause a step."""
    rig = Rig()
    driver = rig.source(WRENCH_EXTERNAL, wrench, 1 / 30)
    rig.source(STATE_EE, tool, 0.09)
    rig.stack.run(3.0)
    rig.service.calls.clear()
    for on in (True, False, False, True):
        driver.on = on
        rig.stack.run(1 / 30)
    driver.on = True
    rig.stack.run(1.0)
    assert rig.service.steps
    assert all(inputs[WRENCH_EXTERNAL].new for inputs, _ in rig.service.steps)


def test_optional_inputs_are_handed_over_and_never_awaited(rig: Rig) -> None:
    rig.stack.run(0.1)
    assert rig.service.steps[-1][0].get(CONTROL_TARGET) is None
    with pytest.raises(KeyError):
        rig.service.steps[-1][0][CONTROL_TARGET]
    rig.stack.client.publish(CONTROL_TARGET, target())
    rig.service.steps.clear()
    rig.stack.run(10.0)
    first, *later = [inputs[CONTROL_TARGET] for inputs, _ in rig.service.steps]
    assert first.new and not any(reading.new for reading in later)
    assert later[-1].age == pytest.approx(10.0, abs=0.02)


def test_an_occasional_input_is_subscribed_to_while_it_is_of_use_and_then_anew() -> None:
    use = False
    rig = Rig(occasional={SENSOR_FT: lambda: use})
    rig.working()
    source = rig.source(SENSOR_FT, ft_sample)
    key, steps = SENSOR_FT.key, rig.service.steps

    def run(duration: float) -> list[Reading | None]:
        steps.clear()
        rig.stack.run(duration)
        return [inputs.get(SENSOR_FT) for inputs, _ in steps]

    assert not any(run(0.2)) and not rig.stack.bus.wanted(key) and key not in rig.runner.subscriptions
    use = True
    readings = run(0.2)
    assert rig.stack.bus.wanted(key) and readings[-1] is not None and readings[-1].new
    use = False
    assert not any(run(0.2)[1:]) and not rig.stack.bus.wanted(key)
    # Whatever was heard before is forgotten: neither an old message nor a fault about the time between is left.
    source.on, use = False, True
    assert not any(run(0.2)) and rig.runner.subscriptions[key].age(rig.stack.scheduler.clock.now_ns()) == -1.0
    source.restart()
    source.on = True
    first = next(reading for reading in run(0.2) if reading is not None)
    assert first.new and first.header.session == source.publisher.session
    assert rig.runner.fault is None


def test_a_message_still_on_its_way_when_an_input_is_left_is_not_used_afterwards() -> None:
    use = True
    rig = Rig(occasional={SENSOR_FT: lambda: use}, latency=0.05)
    rig.working()
    rig.stack.client.publish(SENSOR_FT, ft_sample(1.0))
    use = False
    rig.stack.run(0.02)
    use = True
    rig.service.steps.clear()
    rig.stack.run(0.2)
    assert rig.service.steps and not any(inputs.get(SENSOR_FT) for inputs, _ in rig.service.steps)


def test_two_messages_of_one_instant_are_two(rig: Rig) -> None:
    seen = []
    rig.service.on_step = lambda inputs: seen.append(inputs.get(CONTROL_TARGET))
    for _ in range(2):
        rig.stack.client.publish(CONTROL_TARGET, target())
        rig.stack.scheduler.run_until(rig.stack.scheduler.clock.now_ns())
        rig.runner._call(rig.stack.scheduler.clock.now_ns(), None)
    assert [reading.new for reading in seen if reading] == [True, True]


def test_a_required_input_that_never_ages() -> None:
    rig = Rig(required=(WRENCH_EXTERNAL, STATE_EE, CONTROL_TARGET), optional=())
    rig.source(WRENCH_EXTERNAL, wrench)
    rig.source(STATE_EE, tool)
    rig.stack.run(1.0)
    assert rig.service.brakes[-1][0].key == CONTROL_TARGET.key
    rig.stack.client.publish(CONTROL_TARGET, target())
    rig.stack.run(2.0)
    assert rig.runner.fault is None


def test_dt_is_the_time_between_two_calls_and_clamped(rig: Rig) -> None:
    rig.driver.period = 0.02
    rig.stack.run(0.2)
    assert rig.service.steps[-1][1] == pytest.approx(0.02)
    rig.driver.on = False
    rig.stack.run(1.0)
    assert all(dt <= LONGEST_DT for _, dt in (*rig.service.steps, *rig.service.brakes))


def test_a_timer_drives_where_no_topic_does() -> None:
    rig = Rig(driver=0.002, required=(), optional=(SENSOR_FT, STATE_JOINTS))
    rig.stack.run(1.0)
    assert rig.service.calls == ["step"] * 500


def test_sequences_advance_by_one_and_the_session_stays() -> None:
    rig = Rig()
    headers = []
    rig.stack.client.watch(COMMAND_EE_TWIST, lambda received: headers.append(received.header))
    rig.working()
    rig.stack.run(0.5)
    assert [header.seq for header in headers] == list(range(len(headers)))
    assert len({header.session for header in headers}) == 1


def test_an_output_keeps_the_doubt_of_its_maker(rig: Rig) -> None:
    step = rig.service.step
    rig.service.step = lambda inputs, dt: [  # type: ignore[method-assign]
        type(output)(output.topic, output.message, valid=False) for output in step(inputs, dt)
    ]
    rig.stack.run(0.05)
    assert rig.commands and not any(valid for _, _, valid in rig.commands)
