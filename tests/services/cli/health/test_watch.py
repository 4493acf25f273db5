"""What a view has heard of a stack, and when it has heard enough."""

from __future__ import annotations

from services.cli.health.watch import Watch
from shared.messages import ControlStatus, Health, RobotStatus
from shared.topics import CONTROL_STATUS, STATE_ROBOT, health_topic
from shared.wire.local import LocalBus, Scheduler
from shared.wire.publisher import Publisher

HEALTH = Health("ok", "", 100.0, 100.0, 200.0, 0, {})
ROBOT = RobotStatus("ready", "", "omni", True, 0.25, 0.5, (0.0, 0.0, 0.0))
CONTROL = ControlStatus("waiting", "", "certified", *((0.0,) * 6,) * 3, 0.0, 0.0, 0.0)


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
