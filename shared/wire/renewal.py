"""Whether a process' certificate was replaced while it runs, and whether it ends soon.

Zenoh reads the files anew whenever it dials, and never again once it listens: whoever does has to listen anew.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from shared.wire.credentials import Credentials
from shared.wire.endpoint import BusError

_LOST_FOR = 2.0
"""A connection that is back within this time [s] was not refused."""
_ASK_EVERY = 10.0  # [s]


class Renewal:
    """Looks at the files of a process' credentials, as often as it is asked.

    Args:
        credentials: those in use, which can be used.
    """

    def __init__(self, credentials: Credentials) -> None:
        self._credentials = credentials
        self._taken = self._seen = credentials.stamp()
        self._own = credentials.own()
        self._trouble = ""

    def renewed(self) -> bool:
        """Whether there is another certificate than the last one, which can be used; it is taken over then."""
        stamp = self._credentials.stamp()
        if stamp == self._taken:
            return False
        if stamp != self._seen:
            # They are being written, one after the other: what can be used is what rests from one look to the next.
            self._seen = stamp
            return False
        self._taken = stamp
        try:
            own = self._credentials.own()
            self._credentials.check_time(own)
        except BusError as problem:
            self._trouble = f"{problem}; what was there before is kept for now"
            return False
        # Written anew, or with another file still to come, it may be the same.
        another = own != self._own
        self._own, self._trouble = own, ""
        return another

    def remark(self) -> str:
        """Why changed files are not taken over, or that the certificate has ended or ends soon; empty if neither."""
        if self._trouble:
            return self._trouble
        own, now = self._own, time.time()
        remedy = f"make another one in {self._credentials.folder} with `tandem keys`"
        if own.expired(now):
            return f"the certificate of {own.name} expired on {own.end}: {remedy}"
        return f"the certificate of {own.name} ends on {own.end}: {remedy}" if own.ends_soon(now) else ""


class Lost:
    """Finds out why a router that there was does not take this process any more, such as after a revocation.

    Args:
        credentials: of the process.
        router: its endpoint.
        connected: whether there is a connection to it.
    """

    def __init__(self, credentials: Credentials, router: str, connected: Callable[[], bool]) -> None:
        self._credentials, self._router, self._connected = credentials, router, connected
        self._why = ""
        self._due = 0.0

    def look(self) -> str:
        """Why there is no connection; empty if there is one, or if the reason is no certificate."""
        now = time.monotonic()
        if self._connected():
            self._why, self._due = "", now + _LOST_FOR
        elif now > self._due:
            self._due = now + _ASK_EVERY
            # Aside: it takes up to some seconds, and whoever asks has a robot to brake.
            threading.Thread(target=self._ask, name="why lost", daemon=True).start()
        return self._why

    def _ask(self) -> None:
        self._why = self._credentials.why_refused(self._router)
