"""A participant that is no service: command line, experiments by hand, tests."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, TypeVar

from shared.clock import Clock, SteadyClock
from shared.faults import FaultKind
from shared.parameters import Refused
from shared.processes import speakers
from shared.schema.fields import InvalidField, shown
from shared.schema.records import Record
from shared.topics import LONGEST_REASON, OPERATOR, Query, Topic
from shared.wire.access import may_ask, may_publish, participant_of
from shared.wire.bus import Bus
from shared.wire.codec import Rejected, decode_map, encode_map
from shared.wire.credentials import Credentials
from shared.wire.endpoint import BusError
from shared.wire.publisher import Publisher
from shared.wire.subscription import Received, Subscription

M = TypeVar("M", bound=Record)


class Client:
    """Publishes, watches and asks on a bus, with a header of its own.

    Args:
        bus: on which the others are.
        clock: steady.
        name: by which others know who its session is; empty for who publishes nothing.
        credentials: of its bus; those that the environment names if left out.
    """

    def __init__(
        self, bus: Bus, clock: Clock | None = None, name: str = "", credentials: Credentials | None = None
    ) -> None:
        self.bus = bus
        self.credentials = credentials
        self.clock = clock or SteadyClock()
        self.publisher = Publisher(bus, self.clock)
        self.publish = self.publisher.publish
        if name:
            bus.claim(name, self.publisher.session)

    def watch(self, topic: Topic[M], on_message: Callable[[Received[M]], None] | None = None) -> Subscription[M]:
        """Subscribe; ``on_message`` is called from a thread of the bus and has to return at once."""
        subscription = Subscription(topic, self.clock, on_message)
        self.bus.subscribe(topic.key, subscription.offer)
        return subscription

    def ask(self, query: Query, request: dict[str, Any] | None = None, timeout: float = 3.0) -> dict[str, Any]:
        """Ask a query and return the reply, of which every field is there and of its kind.

        Raises:
            BusError: the certificate does not allow it.
            NoReply: nobody answered within ``timeout`` [s].
            Refused: the answer was a refusal; the text is the reason.
        """
        if why := forbidden(query, self.credentials):
            raise BusError(why)
        asked = request or {}
        try:
            answer = decode_map(self.bus.query(query.key, encode_map(asked), timeout))
        except Rejected as problem:
            raise Refused(f"{query.key} answered with something that is no map: {problem}") from None
        if answer.get("ok") is not True:
            reason = answer.get("error", f"{query.key} refused without a reason")
            # Whoever serves it: one line, of bounded length.
            raise Refused(" ".join(reason.split())[:LONGEST_REASON] if isinstance(reason, str) else shown(reason))
        try:
            query.reply(asked, answer)
        except InvalidField as problem:
            raise Refused(f"{query.key} answered with something else: {problem}") from None
        return answer


def forbidden(what: Topic | Query, credentials: Credentials | None = None) -> str:
    """Why a certificate, or without one that which the environment names, does not allow to publish or ask something;
    empty if it does, or if there is none.
    """
    credentials = credentials or Credentials.given()
    if credentials is None:
        return ""
    name = credentials.own().name
    who = participant_of(name)
    if may_ask(who, what) if isinstance(what, Query) else may_publish(who, what):
        return ""
    word = "ask" if isinstance(what, Query) else "publish"
    return f"the certificate of {name} may not {word} {what.key}; {OPERATOR}'s may (TANDEM_SECURE)"


def unheard(subscription: Subscription) -> str:
    """Why there is no message of a topic: nothing came, or nothing that came could be used; empty if there is one,
    though it may say itself that it is not to be trusted.
    """
    fault = subscription.fault(subscription.now_ns(), math.inf)
    if fault is None or fault.kind is FaultKind.INVALID:
        return ""
    return f"{str(fault).rstrip(chr(46))} See: tandem status"


def unanswered(bus: Bus, query: Query, within: float) -> str:
    """Why there was no answer to a query within a time [s], as far as the bus knows."""
    there = any(not bus.living().isdisjoint(speakers(server)) for server in query.servers)
    why = f"{query.server} lives, but does not answer" if there else f"{query.server} is not running"
    return f"no answer on {query.key} within {within:g} s: {why}. See: tandem status"
