"""A session of Zenoh that another one can take the place of, with all that is declared in it."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import zenoh

from shared.wire.bus import Leave

_GOODBYE = 0.5
"""Time [s] for telling the others that a session ends; nearly always it takes some milliseconds."""

Handle = zenoh.Subscriber | zenoh.Queryable
Declare = Callable[[zenoh.Session], Handle]


class Renewable:
    """One session at a time; between two of them what is said is dropped and nothing is heard.

    Args:
        session: the first.
        publisher: declares the publisher of a key.
    """

    def __init__(self, session: zenoh.Session, publisher: Callable[[zenoh.Session, str], zenoh.Publisher]) -> None:
        self._session: zenoh.Session | None = session
        self._publisher = publisher
        self._lock = threading.Lock()
        self._publishers: dict[str, zenoh.Publisher] = {}
        self._declared: dict[Declare, Handle | None] = {}

    def put(self, key: str, payload: bytes) -> None:
        """Send a payload."""
        publisher = self._publishers.get(key) or self._published(key)
        if publisher is None:
            return
        try:
            publisher.put(payload)
        except zenoh.ZError:
            # Its session may have been given up just now; any other reason is an error.
            if self._publishers.get(key) is publisher:
                raise

    def wanted(self, key: str) -> bool:
        """Whether anybody subscribes to the key."""
        publisher = self._publishers.get(key) or self._published(key)
        # Zenoh's own type hints take this for a bool.
        status: Any = publisher.matching_status if publisher else None
        return bool(status and status.matching)

    def _published(self, key: str) -> zenoh.Publisher | None:
        with self._lock:
            if key not in self._publishers and self._session is not None:
                # Declared once: the first put of an undeclared key costs a round trip each time.
                self._publishers[key] = self._publisher(self._session, key)
            return self._publishers.get(key)

    def declare(self, declare: Declare) -> Leave:
        """Have something declared in this session and each that takes its place, until what is returned is called."""
        with self._lock:
            self._declared[declare] = declare(self._session) if self._session is not None else None

        def leave() -> None:
            with self._lock:
                handle = self._declared.pop(declare)
            if handle is not None:
                # With its session it may have ended just now.
                with suppress(zenoh.ZError):
                    handle.undeclare()

        return leave

    def ask(self, what: Callable[[zenoh.SessionInfo], list[zenoh.ZenohId]]) -> list[zenoh.ZenohId]:
        """Whom the session knows of; nobody while there is none."""
        session = self._session
        try:
            return what(session.info) if session is not None else []
        except zenoh.ZError:
            return []

    def close(self) -> None:
        """End the session; there may be another one."""
        with self._lock:
            session, self._session = self._session, None
            self._publishers = {}
            self._declared = dict.fromkeys(self._declared)
        if session is not None:
            # What is still being handed over may ask for the lock. Where a router hangs Zenoh waits until it has given
            # up dialling it, ten seconds (findings/zenoh-close-hung-router.sh).
            ending = threading.Thread(target=_close, args=(session,), name="close", daemon=True)
            ending.start()
            ending.join(_GOODBYE)

    def renew(self, session: zenoh.Session) -> None:
        """Go on in another session, after ``close``."""
        with self._lock:
            self._session = session
            self._declared = {declare: declare(session) for declare in self._declared}


def _close(session: zenoh.Session) -> None:
    with suppress(zenoh.ZError):  # it did not end in time
        session.close()
