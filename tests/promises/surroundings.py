"""Everybody else around a process: says what its world says, hears what it says, and holds that to what is sound."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import msgpack

from shared.clock import SteadyClock
from shared.messages import Health
from shared.topics import SENSOR_CAMERA, Topic
from shared.wire.bus import NoReply
from shared.wire.codec import decode
from shared.wire.subscription import Received
from shared.wire.zenoh import ZenohBus
from tests.support.stand_in import Spoil, StandIn, every_spoilt
from tests.support.wait import eventually, throughout

if TYPE_CHECKING:
    from tests.promises.subjects import Subject

PATIENCE = 40.0
"""Longest wait [s] for what has to happen; spent only by a test that fails."""
REPLY_WITHIN = 3.0
"""Time [s] that a query may take."""
_PACE = 0.003
"""Time [s] between two spoilt payloads: in one burst the network may drop some of them."""


class Surroundings(StandIn):
    """Whoever the subject meets.

    Attributes:
        heard: by key, every message that the subject has published.
        strange: by key, fields of a second publisher's messages, sent behind each of the first one's.
        missed: by key, how many spoilt payloads were not counted.
    """

    def __init__(self, endpoint: str, subject: Subject) -> None:
        super().__init__(endpoint, subject.name)
        self.subject = subject
        self.heard: dict[str, list[Received[Any]]] = {
            topic.key: self.hear(topic) for topic in subject.outputs
        }
        self.strange: dict[str, dict[str, Any]] = {}
        self.missed: dict[str, int] = {}
        self._other = ZenohBus(connect=endpoint)
        self._says = subject.world(self)

    def turn(self, number: int) -> None:
        for topic, message in self._says(number):
            if topic is SENSOR_CAMERA and not self.bus.wanted(topic.key):
                continue
            self.client.publish(topic, message)
            if topic.key in self.strange:
                self._other.publish(topic.key, self._altered(topic, session=1, **self.strange[topic.key]))

    def _altered(self, topic: Topic, **fields: Any) -> bytes:
        return msgpack.packb({**msgpack.unpackb(self.sent[topic.key]), **fields})

    @contextmanager
    def second_session(self, strange: dict[Topic, dict[str, Any]]) -> Iterator[None]:
        """Somebody else publishes on the same topics what would be accepted of the first one."""
        for topic, fields in strange.items():
            eventually(lambda key=topic.key: key in self.sent, message=f"{topic.key} sent")
            decode(topic.message, self._altered(topic, **fields), topic.cap)
        self.strange = {topic.key: fields for topic, fields in strange.items()}
        yield
        self.strange = {}

    def __exit__(self, *problem: object) -> None:
        super().__exit__(*problem)
        self._other.close()

    def said(self, topic: Topic) -> Any:
        """The newest message of a topic, None before the first."""
        return next((received.message for received in self.heard[topic.key][-1:]), None)

    def fresh(self) -> Received[Any] | None:
        """The newest output if it is of this moment."""
        output = self.subject.output
        age = 2.0 / output.rate if output.rate else 0.5
        for received in self.heard[output.key][-1:]:
            if SteadyClock().now_ns() - received.arrival_ns < max(0.1, age) * 1e9:
                return received
        return None

    def works(self) -> bool:
        """Whether the newest output is fresh, valid and what the subject is there for."""
        latest = self.fresh()
        return latest is not None and latest.header.valid and self.subject.works(latest.message)

    def brakes(self) -> bool:
        """Whether the newest output is marked invalid, and moves nothing."""
        latest = self.fresh()
        return latest is not None and not latest.header.valid and self.subject.rests(latest.message)

    def rests(self) -> bool:
        """Whether the newest output moves nothing, fresh or not."""
        return self.subject.rests(self.said(self.subject.output))

    def break_off(self, topic: Topic, spoil: Spoil) -> None:
        """Have an input spoilt, and wait until the subject brakes for it."""
        self.spoil[topic.key] = spoil
        turns = self.turns
        eventually(lambda: self.turns > turns + 2, message="nothing sound is on its way")
        eventually(self.brakes, PATIENCE, lambda: f"{self.subject.name} brakes: {self.words}")

    def begun(self) -> None:
        """Let the subject work."""
        self.subject.begin(self)
        eventually(self.works, PATIENCE, lambda: f"{self.subject.name} works: {self.words}")

    def goes_on(self, why: str) -> None:
        """It works by itself."""
        eventually(self.works, PATIENCE, lambda: f"{self.subject.name} goes on after {why}: {self.words}")

    @property
    def words(self) -> str:
        """What the subject says for people to read."""
        texts = [getattr(said[-1].message, "reason", "") for said in self.heard.values() if said]
        return "; ".join(filter(None, (self.report.detail if self.health.latest else "", *texts)))

    def names(self, *parts: str) -> None:
        """Wait until it says all of these."""
        eventually(
            lambda: all(part in self.words for part in parts), PATIENCE, lambda: f"{parts} in: {self.words}"
        )

    @property
    def report(self) -> Health:
        """The newest health."""
        assert self.health.latest is not None
        return self.health.latest.message

    def next_report(self) -> Health:
        """A health that was said after this moment."""
        before = self.health.accepted
        eventually(lambda: self.health.accepted > before + 1, PATIENCE, "another health")
        return self.report

    def counts_every_spoilt(self, *topics: Topic) -> None:
        """Send sound payloads in every way spoilt; the health counts each of them under its topic's key."""
        eventually(lambda: all(topic.key in self.sent for topic in topics), message="something sound")
        payloads = {topic.key: every_spoilt(self.sent[topic.key]) for topic in topics}

        def counted() -> bool:
            before = self.next_report().inputs
            for key, spoilt in payloads.items():
                for payload in spoilt:
                    self._other.publish(key, payload)
                    time.sleep(_PACE)
            after = self.next_report().inputs
            missed = {
                key: len(spoilt) - (after[key].rejected - before[key].rejected)
                for key, spoilt in payloads.items()
            }
            self.missed = {key: count for key, count in missed.items() if count}
            return not self.missed

        eventually(
            counted, PATIENCE, lambda: f"every spoilt payload counted, and no more; {self.missed} were not"
        )

    def answer(self, key: str, request: bytes) -> dict[str, Any]:
        """What a query is answered, whatever was asked."""

        def reply() -> dict[str, Any] | None:
            try:
                return msgpack.unpackb(self.bus.query(key, request, REPLY_WITHIN))
            except NoReply:
                return None

        return eventually(reply, PATIENCE, f"an answer of {key}")

    def unharmed(self) -> None:
        """Nothing was ever said that is not sound."""
        for topic, sound in self.subject.sound.items():
            said = [received.message for received in tuple(self.heard[topic.key])]
            wrong = [
                message
                for before, message in itertools.pairwise((said[0], *said))
                if not sound(message, before)
            ]
            assert not wrong, f"{topic.key}: {wrong[0]}"

    def never(self, condition: Callable[[], object], duration: float, what: str) -> None:
        """Hold the opposite against every instant of a while [s]."""
        throughout(lambda: not condition(), duration, what)
