"""Stacks of services in simulated time: deterministic to the bit."""

from __future__ import annotations

import msgpack
import pytest

from shared.loop.stack import Stack
from shared.topics import COMMAND_EE_TWIST, CONTROL_TARGET, SENSOR_FT, STATE_EE, WRENCH_EXTERNAL
from tests.shared.loop.rig import Recorder, Source
from tests.shared.rig import target, tool, wrench


def record(seconds: float, latency: float) -> list[tuple[int, str, dict]]:
    """Everything that two services and two sources say, without what is drawn per process start."""
    stack = Stack(latency)
    log: list[tuple[int, str, dict]] = []

    def tap(key: str) -> None:
        def note(payload: bytes) -> None:
            data = msgpack.unpackb(payload)
            del data["session"]
            log.append((stack.scheduler.clock.now_ns(), key, data))

        stack.bus.subscribe(key, note)

    for key in (COMMAND_EE_TWIST.key, "health/one", "health/two", CONTROL_TARGET.key):
        tap(key)
    stack.add(Recorder(name="one"))
    stack.add(
        Recorder(name="two", driver=0.007, required=(STATE_EE,), optional=(SENSOR_FT,), queries=(), parameters=None)
    )
    Source(stack, WRENCH_EXTERNAL, wrench)
    Source(stack, STATE_EE, tool, 0.004)
    stack.run(seconds / 2)
    stack.client.publish(CONTROL_TARGET, target())
    stack.run(seconds / 2)
    return log


@pytest.mark.parametrize("latency", [0.0, 0.003])
def test_two_runs_are_the_same_to_the_bit(latency: float) -> None:
    first, second = record(2.0, latency), record(2.0, latency)
    assert len(first) > 300
    assert first == second


def test_time_in_a_stack_passes_as_asked() -> None:
    stack = Stack()
    service = Recorder(driver=0.01, required=(), optional=())
    stack.add(service)
    stack.run(1.0)
    assert stack.now == pytest.approx(1.0)
    assert len(service.steps) == 100
    stack.run(5.0, done=lambda: len(service.steps) == 150)
    assert stack.now == pytest.approx(1.5)


def test_a_killed_service_says_nothing_more_and_another_takes_its_place() -> None:
    stack = Stack()
    first, second = (Recorder(driver=0.02, required=(), optional=()) for _ in range(2))
    runner = stack.add(first)
    stack.run(1.0)
    stack.kill(runner)
    steps = len(first.steps)
    assert steps > 0
    stack.add(second)
    stack.run(1.0)
    assert len(first.steps) == steps and len(second.steps) > 0
