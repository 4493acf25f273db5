"""Sends messages with one participant's headers."""

from __future__ import annotations

import secrets
import threading
from collections.abc import Iterable

from shared.clock import Clock
from shared.messages import Header
from shared.schema.records import Record
from shared.topics import Topic
from shared.wire.bus import Bus
from shared.wire.codec import Payload
from shared.wire.turn import Turn


class Publisher:
    """Numbers the messages of each topic within one session, drawn at random.

    Args:
        bus: where to send.
        clock: the participant's steady clock.

    Attributes:
        session: what tells this start of the participant from any other.
    """

    def __init__(self, bus: Bus, clock: Clock) -> None:
        self._bus = bus
        self._clock = clock
        self.session = secrets.randbits(62)
        self._next: dict[str, int] = {}
        self._turns: dict[str, Turn] = {}
        self._sessions: dict[str, int] = {}
        self._lock = threading.Lock()

    def share(self, topic: Topic) -> Turn:
        """Whose turn it is to publish a topic that others may publish too."""
        turn = self._turns[topic.key] = Turn(topic, self.session, self._bus, self._clock)
        return turn

    def renew(self, topics: Iterable[Topic]) -> None:
        """Begin a new session, one for all of these topics: what was heard on them before does not hold any more."""
        session = secrets.randbits(62)
        with self._lock:
            self._sessions |= {topic.key: session for topic in topics}

    def publish(self, topic: Topic, message: Record, valid: bool = True, stamp: int | None = None) -> None:
        """Send one message; ``stamp`` [ns] is when its content was true, now if not given."""
        with self._lock:
            sequence = self._next.get(topic.key, 0)
            self._next[topic.key] = sequence + 1
            session = self._sessions.get(topic.key, self.session)
        if (turn := self._turns.get(topic.key)) is not None:
            turn.speak()
        stamp = self._clock.now_ns() if stamp is None else stamp
        self._bus.publish(topic.key, Payload.of(message, Header.trusted(sequence, session, stamp, bool(valid))))
