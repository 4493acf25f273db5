"""Whose turn it is to publish a topic that several may publish: one at a time, and who was first."""

from __future__ import annotations

from dataclasses import dataclass

from shared.clock import Clock, nanoseconds
from shared.topics import Topic
from shared.wire.bus import Bus
from shared.wire.codec import Rejected, decode
from shared.wire.subscription import HANDOVER_LIMIT, PERIODS_TO_SILENCE

_SILENCE_NS = nanoseconds(HANDOVER_LIMIT)


@dataclass(frozen=True, slots=True)
class _Other:
    """Somebody else on the topic: session, and when it was heard first and last [ns]."""

    session: int
    since: int
    last: int


class Turn:
    """Listens for others on a topic that this participant publishes, or is about to.

    Ask ``taken`` again and again: after a silence of ``HANDOVER_LIMIT`` everything begins anew, as it does for the
    readers, and so it does if this process was not run for as long.

    Args:
        topic: published several times a second.
        session: this participant's own.
        bus: to listen on.
        clock: steady.
    """

    def __init__(self, topic: Topic, session: int, bus: Bus, clock: Clock) -> None:
        self.topic = topic
        self._session = session
        self._bus = bus
        self._clock = clock
        self._listen_ns = nanoseconds(PERIODS_TO_SILENCE / topic.rate)
        self._asked = self._from = clock.now_ns()
        self._begun = self._spoken = -_SILENCE_NS
        self._polite = False
        self._other: _Other | None = None
        bus.present()
        bus.subscribe(topic.key, self._hear)

    def _hear(self, payload: bytes) -> None:
        try:
            session = decode(self.topic.message, payload, self.topic.cap)[0].session
        except Rejected:
            return
        if session != self._session:
            now, other = self._clock.now_ns(), self._other
            goes_on = other is not None and now - other.last <= _SILENCE_NS
            self._other = _Other(session, other.since if other and goes_on else now, now)

    def speak(self) -> None:
        """Take note of an own message."""
        now = self._clock.now_ns()
        if not self.speaking:
            self._begun, self._polite = now, self.listened
        self._spoken = now

    @property
    def speaking(self) -> bool:
        """Whether this participant publishes the topic at present."""
        return self._clock.now_ns() - self._spoken < _SILENCE_NS

    @property
    def listened(self) -> bool:
        """Whether it has been listened for long enough to know whether somebody else is there."""
        return self._clock.now_ns() - self._from >= self._listen_ns

    def taken(self) -> str:
        """Name of who publishes the topic at present and goes first, empty if this participant may.

        Of two that have listened first and began together the lower session goes first.
        """
        now, other = self._clock.now_ns(), self._other
        if now - self._asked > _SILENCE_NS:
            self._from = now
        self._asked = now
        if other is None or now - other.last > _SILENCE_NS:
            return ""
        if self.speaking and other.since >= self._begun:
            together = other.since <= self._begun + self._listen_ns
            if not together or (self._polite and self._session < other.session):
                return ""
        return self._bus.present().get(other.session) or f"session {other.session}"
