"""Whether the router still hands on what is said: through it alone does anybody from outside the chain reach the robot.

Direct links outlive the router, so without this a robot could go on moving while nobody can stop it any more. A router
that was killed is seen by its closed connection; one that hangs keeps its connections, so a beat is sent through it,
from one session of this process to another.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

PERIOD = 0.05  # [s] between two beats
SILENCE = 0.25  # [s] without a beat after which the router hangs: with a period and a step of the robot below 0.3 s


class RouterWatch:
    """Sends beats and waits for them to come back, until ``close``.

    Args:
        connected: whether there is a connection to the router.
        send: sends a beat.
    """

    def __init__(self, connected: Callable[[], bool], send: Callable[[], None]) -> None:
        self._connected = connected
        self._send = send
        self._heard: float | None = None
        self._end = threading.Event()
        threading.Thread(target=self._beat, name="router watch", daemon=True).start()

    def _beat(self) -> None:
        while not self._end.wait(PERIOD):
            self._send()

    def heard(self) -> None:
        """A beat has come back."""
        self._heard = time.monotonic()

    def reason(self) -> str:
        """Why nobody from outside the chain can reach this process, empty if they can."""
        if not self._connected():
            return "the router is gone"
        heard = self._heard
        if heard is None:
            return "the router has not handed on anything yet"
        silent = time.monotonic() - heard
        return f"the router has handed on nothing for {silent:.1f} s" if silent > SILENCE else ""

    def close(self) -> None:
        """Send no more."""
        self._end.set()
