"""What a service says of itself twice a second, whatever the state of its inputs."""

from __future__ import annotations

import math

import pytest

from shared.messages import Health, JointState
from shared.topics import CONTROL_TARGET, STATE_EE, STATE_JOINTS, WRENCH_EXTERNAL, Topic, health_topic
from shared.wire.client import Client
from tests.shared.loop.rig import Rig
from tests.shared.rig import target, tool, wrench


def test_health_at_two_hertz_tells_state_reason_and_inputs() -> None:
    rig = Rig()
    health = []
    topic = health_topic("recorder")
    rig.stack.client.watch(topic, lambda received: health.append(received.message))
    rig.stack.run(1.2)
    assert len(health) == 3
    assert health[-1].state == "starting" and "never received" in health[-1].detail
    assert not health[-1].inputs[WRENCH_EXTERNAL.key].ok
    assert health[-1].inputs[WRENCH_EXTERNAL.key].age == -1.0
    driver = rig.source(WRENCH_EXTERNAL, wrench)
    rig.source(STATE_EE, tool)
    rig.stack.run(2.0)
    assert health[-1].state == "ok" and health[-1].detail == ""
    assert health[-1].loop_hz == pytest.approx(100, abs=2)
    assert health[-1].inputs[WRENCH_EXTERNAL.key].ok
    assert health[-1].inputs[WRENCH_EXTERNAL.key].hz == pytest.approx(100, abs=2)
    rig.service.note = "warm"
    rig.stack.run(0.6)
    assert (health[-1].state, health[-1].detail) == ("degraded", "warm")
    rig.stack.bus.publish(WRENCH_EXTERNAL.key, b"?")
    driver.on = False
    rig.stack.run(0.6)
    assert health[-1].state == "degraded" and "wrench/external" in health[-1].detail
    assert health[-1].inputs[WRENCH_EXTERNAL.key].rejected == 1
    assert not health[-1].inputs[WRENCH_EXTERNAL.key].ok
    assert all(math.isfinite(row.age) for row in health[-1].inputs.values())


def test_health_tells_of_an_optional_input_that_has_failed_and_the_service_goes_on() -> None:
    rig = Rig(optional=(STATE_JOINTS, CONTROL_TARGET))
    health: list[Health] = []
    rig.stack.client.watch(health_topic("recorder"), lambda received: health.append(received.message))
    rig.working()

    def ok(topic: Topic = STATE_JOINTS) -> bool:
        rig.stack.run(1.1)
        return health[-1].inputs[topic.key].ok

    assert ok(), "nobody has to send it"
    joints = rig.source(STATE_JOINTS, lambda: JointState((), (), (), ()))
    assert ok()
    joints.valid = False
    assert not ok(), "marked invalid"
    joints.valid = True
    assert ok()
    joints.on = False
    assert not ok(), "silent"
    rig.stack.client.publish(CONTROL_TARGET, target())
    assert ok(CONTROL_TARGET), "holds until it is replaced"
    assert {row.state for row in health[-10:]} == {"ok"} and not rig.service.brakes


@pytest.mark.parametrize("occasional", [False, True])
def test_an_input_of_which_all_is_refused_is_not_ok_although_nobody_needs_it(occasional: bool) -> None:
    rig = Rig(occasional={STATE_JOINTS: lambda: True}) if occasional else Rig(optional=(STATE_JOINTS,))
    health: list[Health] = []
    rig.stack.client.watch(health_topic("recorder"), lambda received: health.append(received.message))
    rig.working()
    joints = rig.source(STATE_JOINTS, lambda: JointState((), (), (), ()))
    rig.stack.run(1.1)
    assert health[-1].state == "ok"
    joints.on = False
    for _ in range(20):
        rig.stack.bus.publish(STATE_JOINTS.key, b"?")
        rig.stack.run(0.1)
    assert health[-1].state == "degraded" and not health[-1].inputs[STATE_JOINTS.key].ok
    assert "state/joints: " in health[-1].detail and "messages rejected, the last one: " in health[-1].detail
    assert "messages rejected" in rig.service.steps[-1][0].refused(STATE_JOINTS), "a step is told too"
    joints.on = True
    rig.stack.run(1.1)
    assert health[-1].state == "ok" and not rig.service.steps[-1][0].refused(STATE_JOINTS) and not rig.service.brakes


def test_a_second_publisher_is_named_by_whoever_hears_it() -> None:
    rig = Rig()
    health: list[Health] = []
    rig.stack.client.watch(health_topic("recorder"), lambda received: health.append(received.message))
    rig.working()
    hold, task = (Client(rig.stack.bus, rig.stack.scheduler.clock) for _ in range(2))
    rig.stack.bus.claim("hold", hold.publisher.session)
    rig.stack.bus.claim("task", task.publisher.session)
    for _ in range(6):
        hold.publish(CONTROL_TARGET, target())
        task.publish(CONTROL_TARGET, target())
        rig.stack.run(0.2)
    assert health[-1].state == "degraded"
    assert "control/target: task publishes it too and is refused, since hold was first" in health[-1].detail


def test_silence_says_whether_its_publisher_is_there(monkeypatch: pytest.MonkeyPatch) -> None:
    rig = Rig()
    rig.working()
    rig.driver.on = False

    def said() -> str:
        rig.stack.run(0.3)
        return rig.service.brakes[-1][0].text

    assert said().endswith("allowed are 30 ms. Is wrench running?")
    rig.stack.bus.claim("wrench", 5)
    assert said().endswith("wrench is alive, but nothing of it arrives here")
    monkeypatch.setattr(rig.stack.bus, "connected", lambda: False)
    assert said().endswith("There is no connection to the router. Is it running?")


def test_a_service_is_alive_by_its_name_and_by_its_session() -> None:
    bus = Rig().stack.bus
    assert bus.living() == {"recorder"} and len(bus.sessions("recorder")) == 1
