"""The door that every service comes in by: one of a kind at a time, and who comes second is told who is first.

A liveliness token outlives a process that hangs or is cut off by the bus' lease, so whoever meets one waits for its end
before it concludes; where there is none, nobody waits. Of two that start at the same instant the lower session enters:
each claims first and looks then, so that at least one sees the other, and enters only if it sees nobody.
"""

from __future__ import annotations

import time
from collections.abc import Callable

from shared.processes import same_kind
from shared.wire.bus import Bus, Leave

SECOND = 3
"""Exit status of a process that was second of its kind."""
LEASE_OVER = 2.0
"""Time [s] after which a token that is still there belongs to a process that lives: twice Zenoh's lease here."""
BOTH_FOR = 2.0 * LEASE_OVER
"""Time [s] for which two have to be in before one leaves: who only waits at the door is gone by then."""
_LOOK = 0.05  # [s] between two looks


class Occupied(Exception):
    """Another one of this kind is there; the text is one line for the user."""


class Door:
    """Lets one start of a service in.

    Args:
        bus: on which the others are.
        name: of the service.
        session: of this start.
        where: robot and network, in words.
    """

    def __init__(self, bus: Bus, name: str, session: int, where: str) -> None:
        self._bus = bus
        self._name = name
        self._session = session
        self._where = where
        self._met: dict[int, float] = {}

    def enter(self, give_up: Callable[[], bool]) -> None:
        """Return when this start is the only one of its kind, which holds its token then, or when told to give up.

        Raises:
            Occupied: another one stays.
        """
        deadline = time.monotonic() + LEASE_OVER
        give_back: Leave | None = None
        while not give_up():
            others = self._others()
            if give_back and not others:
                return
            behind = any(session < self._session for session in others)
            late = bool(others) and time.monotonic() > deadline
            if give_back and (behind or late):
                give_back()
                give_back = None
            if late:
                # Others who waited in vain are gone by now too: who is left is the one.
                time.sleep(2.0 * _LOOK)
                if others := self._others():
                    raise Occupied(self._told(others[min(others)], min(others)))
            if give_back is None and not behind:
                give_back = self._bus.claim(self._name, self._session)
                continue
            time.sleep(_LOOK)

    def gives_way(self) -> str:
        """Why this start has to leave again, empty if it need not: two that did not see each other, as over a network
        that was cut or while one of them hung, are both in then, and the lower session stays.
        """
        now = time.monotonic()
        kind = same_kind(self._name)
        others = {key: name for key, name in self._bus.present().items() if name in kind and key != self._session}
        self._met = {session: self._met.get(session, now) for session in others}
        for session, since in self._met.items():
            if session < self._session and now - since > BOTH_FOR:
                return self._told(others[session], session)
        return ""

    def _others(self) -> dict[int, str]:
        """Everybody else of this kind, by session."""
        found = {session: name for name in same_kind(self._name) for session in self._bus.sessions(name)}
        found.pop(self._session, None)
        return found

    def _told(self, name: str, session: int) -> str:
        return (
            f"{name} runs already {self._where} (session {session}), and two of a kind would both publish: this one "
            "ends. To take over, end the other one first (Ctrl-C or SIGTERM where it runs), then start this one again"
        )
