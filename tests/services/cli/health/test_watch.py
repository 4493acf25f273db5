"""What a view has heard of a stack, and when it has heard enough."""

from __future__ import annotations

import math

from services.cli.health.watch import Watch
from shared.messages import ControlStatus, Health, JointState, RobotStatus
from shared.topics import CONTROL_STATUS, CONTROL_TARGET, STATE_JOINTS, STATE_ROBOT, health_topic
from shared.wire.client import Client
from shared.wire.codec import encode_map
from shared.wire.local import LocalBus, Scheduler
from shared.wire.publisher import Publisher
from tests.shared.rig import target

HEALTH = Health("ok", "", 100.0, 100.0, 200.0, 0, {})
ROBOT = RobotStatus("ready", "", "omni", True, 0.25, 0.5, (0.0, 0.0, 0.0))
CONTROL = ControlStatus("waiting", "", "certified", *((0.0,) * 6,) * 3, 0.0, 0.0, 0.0)


def test_what_is_refused_and_what_two_publish_is_told_by_topic() -> None:
    scheduler = Scheduler()
    bus = LocalBus(scheduler)
    watch = Watch(bus, scheduler.clock)
    efforts = JointState(("a",), (0.0,), (0.0,), (0.0,)).to_plain() | {"effort": [math.nan]}
    hold, task = (Client(bus, scheduler.clock, name) for name in ("hold", "task"))
    for number in range(30):
        header = {"seq": number, "session": 1, "stamp": number, "valid": True}
        bus.publish(STATE_JOINTS.key, encode_map(header | efforts))
        for client in (hold, task):
            client.publish(CONTROL_TARGET, target())
        scheduler.run_until(scheduler.clock.now_ns() + 10**7)
    trouble = watch.trouble()
    assert set(trouble) == {STATE_JOINTS.key, CONTROL_TARGET.key}
    assert trouble[STATE_JOINTS.key].startswith("state/joints: 30 messages rejected, the last one: effort")
    assert trouble[CONTROL_TARGET.key].startswith("control/target is published by hold and task")


def test_it_is_complete_once_every_service_and_both_states_were_heard() -> None:
    scheduler = Scheduler()
    bus = LocalBus(scheduler)
    publisher = Publisher(bus, scheduler.clock)
    watch = Watch(bus, scheduler.clock)
    services = {"sim", "base"}
    told = (
        (health_topic("sim"), HEALTH),
        (STATE_ROBOT, ROBOT),
        (CONTROL_STATUS, CONTROL),
        (health_topic("base"), HEALTH),
    )
    for topic, message in told:
        assert not watch.complete(services)
        publisher.publish(topic, message)
        scheduler.run_until(scheduler.clock.now_ns())
    assert watch.complete(services)
    assert not watch.complete({*services, "task"})
