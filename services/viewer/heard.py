"""What was heard: the newest message of each topic, and what came since it was last drawn, both bounded."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable

from services.viewer.sample import Sample
from services.viewer.sentence import Known, Told
from shared.clock import Clock, seconds
from shared.processes import HEALTHY
from shared.topics import TOPICS, Topic, health_topic
from shared.wire.subscription import Received, Subscription

WATCHED: tuple[Topic, ...] = (*TOPICS, *(health_topic(name) for name in HEALTHY))
"""All that a viewer may read."""
_WAITING = 100
"""Messages of one topic that wait to be drawn, a second's worth; of more the oldest are left out."""


class Ears:
    """Takes in payloads, live or recorded, by the rules that every reader of a topic has.

    Attributes:
        subscriptions: by key.

    Args:
        clock: of the arrivals.
        start_ns: its time [ns] that counts as the beginning.
    """

    def __init__(self, clock: Clock, start_ns: int) -> None:
        self._clock, self._start = clock, start_ns
        self._lock = threading.Lock()
        self._forgotten: dict[str, int] = {}
        self._waiting: dict[str, deque[Sample]] = {topic.key: deque(maxlen=_WAITING) for topic in WATCHED}
        self.subscriptions = {topic.key: Subscription(topic, clock, self._keep(topic.key)) for topic in WATCHED}

    def _keep(self, key: str) -> Callable[[Received], None]:
        waiting = self._waiting[key]

        def on_message(received: Received) -> None:
            with self._lock:
                waiting.append(Sample(seconds(received.arrival_ns - self._start), received.message))

        return on_message

    def hear(self, key: str, payload: bytes) -> None:
        """Take in a payload; one under a key of which nothing is drawn is left out."""
        if (subscription := self.subscriptions.get(key)) is not None:
            subscription.offer(payload)

    def forget(self, key: str) -> None:
        """Tell nothing of a key any more until it is heard again: nobody listens, so its age would mean nothing."""
        self._forgotten[key] = self._clock.now_ns()
        self.take(key)

    @property
    def now_ns(self) -> int:
        """The clock's time [ns]."""
        return self._clock.now_ns()

    @property
    def now(self) -> float:
        """Time [s] since the beginning."""
        return seconds(self.now_ns - self._start)

    def newest(self, key: str) -> Told | None:
        """The newest message of a key and its age [s]; None before the first one, and of what is forgotten."""
        one = self.subscriptions[key]
        last = one.latest
        if last is None or last.arrival_ns <= self._forgotten.get(key, last.arrival_ns - 1):
            return None
        return Told(last.message, max(0.0, one.age(self.now_ns)))

    def take(self, key: str) -> list[Sample]:
        """What has arrived under a key since the last call, the oldest first."""
        waiting = self._waiting[key]
        with self._lock:
            taken = list(waiting)
            waiting.clear()
        return taken

    def known(self) -> Known:
        """The newest message of every topic of which there is one, with its age."""
        return {key: told for key in self.subscriptions if (told := self.newest(key)) is not None}
