"""The receiving end of one topic: what arrives is validated, ordered and timed here, once, for every service."""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from shared import faults
from shared.clock import Clock, nanoseconds, seconds
from shared.faults import Fault
from shared.messages import LONGEST_TTL, Header
from shared.schema.records import Record
from shared.topics import ANYBODY, Topic
from shared.wire.codec import Rejected, decode

M = TypeVar("M", bound=Record)

PERIODS_TO_SILENCE = 3
"""A periodic input is silent when this many of its periods have passed without a message."""
SLOWEST_PERIOD = 1 / 30
"""Longest period [s] that widens the allowed age; a slower publisher counts as silent in between."""
LOSS_LIMIT = 1 / 3
"""Share of lost messages [1] within a second above which an input is not used: 20 % on average must still pass."""
HANDOVER_LIMIT = 1.0
"""Longest silence [s] of a publisher before another session may take over its topic."""
TOLD_FOR = 10.0
"""Time [s] for which a refused message of a topic that comes on change only is told, such as a stop."""
CLOCK_DRIFT = 50e-6
"""Assumed drift [1] between two machines' steady clocks; hides a delay that grows more slowly than this."""
_WINDOW_NS = 1_000_000_000
_FEWEST_SENT = 20
"""Fewest messages of which a lost share says something; whoever sends more rarely is watched for silence alone."""


@dataclass(slots=True)
class Received(Generic[M]):
    """One accepted message with its number among the accepted ones, its arrival [ns, receiver's clock] and its delay
    [s] beyond the fastest one's.
    """

    number: int
    header: Header
    message: M
    arrival_ns: int
    delay: float


class Subscription(Generic[M]):
    """Validates, orders and times the messages of one topic; keeps the newest.

    ``offer`` may be called from any thread; everything else reads a consistent snapshot.

    Args:
        topic: row of the table.
        clock: the receiver's steady clock.
        on_message: called with each accepted message, from the thread that offered it.
        named: name of the participant of a session, empty if not known.
        noted: given when [ns] each payload arrived, good or bad, after it was taken in.
    """

    def __init__(
        self,
        topic: Topic[M],
        clock: Clock,
        on_message: Callable[[Received[M]], None] | None = None,
        named: Callable[[int], str] = lambda session: "",
        noted: Callable[[int, bytes], None] = lambda arrival, payload: None,
    ) -> None:
        self.topic = topic
        self._clock = clock
        self._on_message = on_message
        self._named = named
        self._noted = noted
        self._lock = threading.Lock()
        self._latest: Received[M] | None = None
        self._behind: Header | None = None
        self._fastest_transit = 0
        self._period = 0.0
        self._arrivals: deque[tuple[int, int]] = deque()
        self._unused = 0
        self._unused_ns = 0
        self._reason = ""
        self._second: tuple[int, int] | None = None
        self.accepted = 0
        self.rejected = 0
        self.last_rejection = ""
        self.out_of_order = 0
        self.second_session = 0

    def now_ns(self) -> int:
        """The receiver's clock [ns]."""
        return self._clock.now_ns()

    @property
    def latest(self) -> Received[M] | None:
        """The newest accepted message."""
        return self._latest

    @property
    def period(self) -> float:
        """Measured period [s] of the publisher, 0 before two messages."""
        return self._period

    @property
    def age_limit(self) -> float:
        """Age [s] above which the last message is not used."""
        return max(self.topic.max_age, PERIODS_TO_SILENCE * min(self._period or SLOWEST_PERIOD, SLOWEST_PERIOD))

    def offer(self, payload: bytes) -> None:
        """Take in a payload as it arrived; a bad one is counted and changes nothing else."""
        arrival = self._clock.now_ns()
        try:
            header, message = decode(self.topic.message, payload, self.topic.cap)
        except Rejected as problem:
            with self._lock:
                self.rejected += 1
                self.last_rejection = str(problem)
                self._leave_unused(self.last_rejection, arrival)
                self._noted(arrival, payload)
            return
        with self._lock:
            received = self._accept(header, message, arrival)
            self._noted(arrival, payload)
        if received is not None and self._on_message is not None:
            self._on_message(received)

    def _leave_unused(self, reason: str, arrival: int) -> None:
        self._unused += 1
        self._unused_ns, self._reason = arrival, reason

    def _accept(self, header: Header, message: M, arrival: int) -> Received[M] | None:
        previous = self._latest
        if previous is not None and header.session != previous.header.session:
            if self._held(previous, arrival):
                self.second_session += 1
                self._second = header.session, arrival
                return None
            previous = None
        if previous is not None and (header.seq <= previous.header.seq or header.stamp < previous.header.stamp):
            self.out_of_order += 1
            order = f"number {header.seq} came after {previous.header.seq}"
            if header.seq > previous.header.seq:
                order += f" and is stamped {seconds(previous.header.stamp - header.stamp):.3f} s before it"
            self._leave_unused(f"{order}: sent twice, or held up on the way", arrival)
            if not self._counts_anew(header, previous, arrival):
                return None
            previous = None
        transit = arrival - header.stamp
        if previous is not None:
            elapsed = seconds(header.stamp - previous.header.stamp) / (header.seq - previous.header.seq)
            self._period = elapsed if self._period == 0.0 else self._period + 0.1 * (elapsed - self._period)
            crept = self._fastest_transit + round(CLOCK_DRIFT * (arrival - previous.arrival_ns))
            self._fastest_transit = min(crept, transit)
        else:
            self._period = 0.0
            self._fastest_transit = transit
            self._arrivals.clear()
        self._arrivals.append((arrival, header.seq))
        self._trim(arrival)
        self.accepted += 1
        self._unused = 0
        delay = seconds(transit - self._fastest_transit)
        self._latest = Received(self.accepted, header, message, arrival, delay)
        return self._latest

    def _counts_anew(self, header: Header, last: Received[M], arrival: int) -> bool:
        """Whether a publisher advances again behind a message of its session that is long gone.

        Without this one message with a sequence number or a stamp far ahead would make the topic deaf for ever.
        """
        before, self._behind = self._behind, header
        return (
            before is not None
            and header.session == before.session
            and header.seq > before.seq
            and header.stamp > before.stamp
            and arrival - last.arrival_ns > nanoseconds(HANDOVER_LIMIT)
        )

    def _held(self, last: Received[M], arrival: int) -> bool:
        """Whether the last message's session still holds the topic; a command holds it for as long as it acts."""
        if ANYBODY in self.topic.publishers:
            return False
        ttl = getattr(last.message, "ttl", None)
        silence = min(self.age_limit, HANDOVER_LIMIT) if ttl is None else min(ttl, LONGEST_TTL)
        return arrival - last.arrival_ns < nanoseconds(silence)

    def _trim(self, now: int) -> None:
        while self._arrivals and now - self._arrivals[0][0] > _WINDOW_NS:
            self._arrivals.popleft()

    def age(self, now_ns: int) -> float:
        """Age [s] of the newest message: time since its arrival plus its delay on the way; -1 if there is none."""
        last = self._latest
        return -1.0 if last is None else seconds(now_ns - last.arrival_ns) + last.delay

    def rate(self, now_ns: int) -> float:
        """Messages per second over the last second [Hz]."""
        with self._lock:
            self._trim(now_ns)
            if len(self._arrivals) < 2:
                return float(len(self._arrivals))
            span = max(self._arrivals[-1][0], now_ns - nanoseconds(self._period)) - self._arrivals[0][0]
            return (len(self._arrivals) - 1) / seconds(span) if span > 0 else 0.0

    def loss(self) -> float:
        """Share [1] of the last second's messages that never arrived."""
        with self._lock:
            sent = self._arrivals[-1][1] - self._arrivals[0][1] if self._arrivals else 0
            if sent < _FEWEST_SENT:
                return 0.0
            return 1.0 - (len(self._arrivals) - 1) / sent

    def waiting_since(self, number: int) -> int:
        """Arrival [ns] of the first message accepted after the one of this number, at most a second ago."""
        with self._lock:
            waiting = min(max(1, self.accepted - number), len(self._arrivals))
            return self._arrivals[-waiting][0]

    @property
    def refusals(self) -> str:
        """Refusals since the start, in words; empty if there are none."""
        if not (self.rejected or self.out_of_order or self.second_session):
            return ""
        cases = (
            (self.rejected, f"rejected ({self.last_rejection})"),
            (self.out_of_order, "out of sequence"),
            (self.second_session, f"from a second session refused ({self._who(self._second)})"),
        )
        return ", ".join(f"{count} {text}" for count, text in cases if count)

    def _who(self, second: tuple[int, int] | None) -> str:
        session = second[0] if second else 0
        return self._named(session) or f"session {session}"

    def second(self, now_ns: int) -> tuple[str, str] | None:
        """Who publishes the topic at present and is refused, and who was first here; None if there is one publisher."""
        second, last = self._second, self._latest
        if second is None or last is None or now_ns - second[1] > nanoseconds(HANDOVER_LIMIT):
            return None
        if second[0] == last.header.session:  # it has taken over
            return None
        return self._who(second), self._who((last.header.session, 0))

    def refused(self, now_ns: int) -> Fault | None:
        """That nothing of what arrives at present is used, and why."""
        if not self._unused:
            return None
        last, limit, ago = self._latest, self.age_limit, seconds(now_ns - self._unused_ns)
        if limit == math.inf:
            told = ago <= TOLD_FOR
        elif last is None:
            told = True
        else:
            told = seconds(now_ns - last.arrival_ns) > limit and ago <= max(HANDOVER_LIMIT, limit)
        return None if not told else faults.refused(self.topic.key, self._unused, self._reason)

    def fault(self, now_ns: int, max_delay: float) -> Fault | None:
        """Why the newest message must not be used, or None.

        Args:
            now_ns: receiver's clock [ns].
            max_delay: declared bound [s] on the delay beyond the fastest message's.
        """
        last = self._latest
        key = self.topic.key
        if last is None:
            return self.refused(now_ns) or faults.never_seen(key, self.topic.publisher)
        age, limit = seconds(now_ns - last.arrival_ns), self.age_limit
        if age > limit:
            return self.refused(now_ns) or faults.silent(key, self.topic.publisher, age, limit)
        if last.delay > max_delay:
            return faults.delayed(key, last.delay, max_delay)
        if (share := self.loss()) > LOSS_LIMIT:
            return faults.lossy(key, share, LOSS_LIMIT)
        if not last.header.valid:
            return faults.invalid(key, getattr(last.message, "fault", ""))
        return None
