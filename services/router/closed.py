"""What the router of a closed network does besides routing: looks after its certificate, and says whom it refused."""

from __future__ import annotations

import secrets
import time
from collections.abc import Callable, Sequence
from typing import Any

from services.router.refusals import Refusals
from shared.clock import SteadyClock
from shared.messages import Header, Health
from shared.processes import ROUTER
from shared.topics import HEALTH_RATE, health_topic
from shared.wire.codec import Payload
from shared.wire.credentials import Credentials
from shared.wire.endpoint import port_of
from shared.wire.renewal import Renewal

_HEALTH = health_topic(ROUTER.name)


class Closed:
    """Looks after one router; made before its session.

    Args:
        credentials: its certificate.
        listen: endpoint that it listens on.
        robots: first chunks of the keys under which it tells its health.
        report: told what is new, one line.
    """

    def __init__(
        self, credentials: Credentials, listen: str, robots: Sequence[str], report: Callable[[str], None]
    ) -> None:
        self._renewal = Renewal(credentials)
        self._refusals = Refusals(port_of(listen), report)
        self._robots = robots
        self._report = report
        self._told = ""
        self._health_due = 0.0
        self._session, self._sequence, self._clock = secrets.randbits(62), 0, SteadyClock()
        self._listener: Any = None

    def opened(self, session: Any) -> None:
        """The router listens, with what is in the files now."""
        self._listener = session.info.declare_link_events_listener(
            lambda event: self._refusals.accepted(str(event.link.dst)), history=True
        )

    def look(self, session: Any) -> bool:
        """Tell health if it is due; true if there is another certificate, with which to listen anew."""
        renewed = self._renewal.renewed()
        remark = self._renewal.remark()
        if remark != self._told:
            self._told = remark
            if remark:
                self._report(remark)
        if time.monotonic() >= self._health_due:
            self._health_due = time.monotonic() + 1.0 / HEALTH_RATE
            self._tell(session, "; ".join(filter(None, (remark, str(self._refusals)))))
        return renewed

    def _tell(self, session: Any, detail: str) -> None:
        health = Health("ok", detail, 0.0, 0.0, 0.0, 0, {})
        header = Header.trusted(self._sequence, self._session, self._clock.now_ns(), True)
        self._sequence += 1
        for robot in self._robots:
            session.put(f"{robot}/{_HEALTH.key}", Payload.of(health, header))
