"""Everybody else around a process: says what its world says, hears what it says, and holds that to what is sound."""

from __future__ import annotations

import itertools
import time
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import msgpack

from shared.clock import SteadyClock
from shared.messages import Health
from shared.topics import Topic
from shared.wire.bus import NoReply
from shared.wire.codec import decode
from shared.wire.subscription import Received
from shared.wire.zenoh import ZenohBus
from tests.support.stand_in import Spoil, StandIn, altered, every_spoilt
from tests.support.wait import eventually

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
        missed: by key, how many spoilt payloads were not counted.
    """

    def __init__(self, endpoint: str, subject: Subject) -> None:
        super().__init__(endpoint, subject.process.known_as)
        self.subject = subject
        self.plays = subject.world(self)
        self.heard: dict[str, list[Received[Any]]] = {topic.key: self.hear(topic) for topic in subject.outputs}
        self.missed: dict[str, int] = {}
        self._other = ZenohBus(connect=endpoint)

    def second_session(self, topic: Topic, **fields: Any) -> Spoil:
        """Somebody else publishes beside the first one, who would be believed if he said that."""
        decode(topic.message, altered(self.sent[topic.key], **fields), topic.cap)

        def both(payload: bytes) -> Iterator[bytes]:
            yield payload
            # Behind the first one: whoever speaks after a silence has the topic.
            self._other.publish(topic.key, altered(payload, session=1, **fields))

        return both

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

    def break_off(self, topic: Topic, spoil: Spoil) -> None:
        """Have an input spoilt, and wait until the subject brakes for it."""
        self.spoil[topic.key] = spoil
        turns = self.turns
        eventually(lambda: self.turns > turns + 2, message="nothing sound is on its way")
        eventually(self.brakes, PATIENCE, lambda: f"{self.subject.name} brakes: {self.words}")

    def begun(self) -> None:
        """Let the subject work."""
        self.subject.begin(self)
        self.goes_on("being asked")

    def goes_on(self, after: str) -> None:
        """It works by itself."""
        eventually(self.works, PATIENCE, lambda: f"{self.subject} goes on after {after}: {self.words}")

    @property
    def words(self) -> str:
        """What the subject says for people to read."""
        texts = [getattr(said[-1].message, "reason", "") for said in self.heard.values() if said]
        return "; ".join(filter(None, (self.report.detail if self.health.latest else "", *texts)))

    def names(self, *parts: str) -> None:
        """Wait until it says all of these."""
        eventually(lambda: all(part in self.words for part in parts), PATIENCE, lambda: f"{parts} in: {self.words}")

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
        payloads = {topic.key: every_spoilt(self.sent[topic.key]) for topic in topics}

        def counted() -> bool:
            before = self.next_report().inputs
            for key, spoilt in payloads.items():
                for payload in spoilt:
                    self._other.publish(key, payload)
                    time.sleep(_PACE)
            after = self.next_report().inputs
            missed = {
                key: len(spoilt) - (after[key].rejected - before[key].rejected) for key, spoilt in payloads.items()
            }
            self.missed = {key: count for key, count in missed.items() if count}
            return not self.missed

        eventually(counted, PATIENCE, lambda: f"every spoilt payload counted, and no more; {self.missed} were not")

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
            wrong = [message for before, message in itertools.pairwise((said[0], *said)) if not sound(message, before)]
            assert not wrong, f"{topic.key}: {wrong[0]}"
