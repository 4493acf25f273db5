"""Whether a process' certificate was replaced while it runs, and whether it ends soon.

Zenoh reads the files anew whenever it dials, and never again once it listens.
"""

from __future__ import annotations

import time

from shared.wire.credentials import Credentials
from shared.wire.endpoint import BusError


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
        """Whether the files are others than those taken over last, and can be used; then they are taken over."""
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
        self._own, self._trouble = own, ""
        return True

    def look(self) -> str:
        """What is to be known of the certificate after another look at the files, for who does not listen."""
        self.renewed()
        return self.remark()

    def remark(self) -> str:
        """Why changed files are not taken over, or that the certificate has ended or ends soon; empty if neither."""
        if self._trouble:
            return self._trouble
        own, now = self._own, time.time()
        remedy = f"make another one in {self._credentials.folder} with `tandem keys`"
        if own.expired(now):
            return f"the certificate of {own.name} expired on {own.end}: {remedy}"
        return f"the certificate of {own.name} ends on {own.end}: {remedy}" if own.ends_soon(now) else ""
