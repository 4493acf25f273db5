"""What a certificate says: whose it is, and when it ends.

Python's standard library reads a certificate only while it verifies one, so the files shake hands with each other, in
memory. That tells as well whether they belong together.
"""

from __future__ import annotations

import ssl
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

_NO_CHECK_TIME = 0x200000  # X509_V_FLAG_NO_CHECK_TIME, to which ssl.VerifyFlags gives no name
_ROUNDS = 5  # a handshake has three
_DAY = 86400.0
_LAST_DAYS = 14.0
"""A certificate ends soon when less is left than this, or than a tenth of its whole time."""


@dataclass(frozen=True)
class Certificate:
    """One certificate.

    Attributes:
        name: common name.
        begins: Unix time [s].
        ends: Unix time [s].
        serial: number that its authority has given it.
    """

    name: str
    begins: float
    ends: float
    serial: str = ""

    @property
    def end(self) -> str:
        """When it ends, for a human."""
        return time.strftime("%Y-%m-%d %H:%M:%S UTC", time.gmtime(self.ends))

    def expired(self, now: float) -> bool:
        """Whether it has ended by a Unix time [s]."""
        return now >= self.ends

    def ends_soon(self, now: float) -> bool:
        """Whether it is time to make another one."""
        return self.ends - now < min(_LAST_DAYS * _DAY, 0.1 * (self.ends - self.begins))


def read_certificate(authority: Path, certificate: Path, key: Path) -> Certificate:
    """A certificate, valid at present or not, of which this is the key and which this authority has signed.

    Raises:
        OSError: one of the files cannot be read, or what they hold cannot be used (``ssl.SSLError``).
    """
    shown, asked = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER), ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    shown.load_cert_chain(certificate, key)
    asked.load_verify_locations(authority)
    asked.check_hostname = False
    asked.verify_flags |= _NO_CHECK_TIME
    there, back = ssl.MemoryBIO(), ssl.MemoryBIO()
    asking = asked.wrap_bio(back, there)
    showing = shown.wrap_bio(there, back, server_side=True)
    for _ in range(_ROUNDS):
        for side in (asking, showing):
            with suppress(ssl.SSLWantReadError):
                side.do_handshake()
    said: Any = asking.getpeercert()
    names = [value for part in said["subject"] for kind, value in part if kind == "commonName"]
    begins, ends = (ssl.cert_time_to_seconds(said[what]) for what in ("notBefore", "notAfter"))
    return Certificate("".join(names[:1]), begins, ends, said["serialNumber"])
