"""Listening to a stack: the newest message and the rate of every topic, the health of every service."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from services.cli.health.diagnose import Heard
from shared import topics
from shared.clock import Clock, SteadyClock
from shared.processes import HEALTHY
from shared.topics import Topic, health_topic
from shared.wire.bus import Bus
from shared.wire.subscription import Subscription


class Watch:
    """Subscribes to every topic (images excepted, which are made only while somebody subscribes)."""

    def __init__(self, bus: Bus, clock: Clock | None = None, also: str = "") -> None:
        """Starts listening on `bus`, to the images too if `also` is their key."""
        self._clock = clock or SteadyClock()
        self._bus = bus
        watched: list[Topic] = [
            topic for topic in topics.TOPICS if topic is not topics.SENSOR_CAMERA or topic.key == also
        ]
        watched += [health_topic(service) for service in HEALTHY]
        self.subscriptions = {topic.key: Subscription(topic, self._clock, named=self._named) for topic in watched}
        for key, subscription in self.subscriptions.items():
            bus.subscribe(key, subscription.offer)

    def _named(self, session: int) -> str:
        return self._bus.present().get(session, "")

    def trouble(self) -> dict[str, str]:
        """By key, what is wrong with what arrives at present: nothing of it can be used, or two publish it."""
        now, found = self._clock.now_ns(), {}
        for key, subscription in self.subscriptions.items():
            if refused := subscription.refused(now):
                found[key] = refused.text
            elif two := subscription.second(now):
                found[key] = f"{key} is published by {' and '.join(sorted(two))}: one of them is refused"
        return found

    def message(self, topic: Topic, fresh: float = 1.0) -> Any:
        """The newest message, None if there is none younger than `fresh` [s]."""
        subscription = self.subscriptions[topic.key]
        latest, age = subscription.latest, subscription.age(self._clock.now_ns())
        return latest.message if latest is not None and 0 <= age <= fresh else None

    def rate(self, topic: Topic) -> float:
        """Messages of the last second [Hz]."""
        return self.subscriptions[topic.key].rate(self._clock.now_ns())

    def health(self) -> dict[str, Heard]:
        """Every service of which health was heard."""
        heard = {}
        for service in HEALTHY:
            subscription = self.subscriptions[f"health/{service}"]
            if subscription.latest is not None:
                heard[service] = Heard(subscription.latest.message, subscription.age(self._clock.now_ns()))
        return heard

    def living(self) -> set[str]:
        """Services that hold a liveliness token."""
        return self._bus.living()

    def complete(self, services: Collection[str]) -> bool:
        """Whether every one of the services was heard, and the robot and the controller have told their state."""
        told = (self.message(topic) is not None for topic in (topics.STATE_ROBOT, topics.CONTROL_STATUS))
        return self.health().keys() >= set(services) and all(told)
