"""Connections that the router's listener has refused: how many, why, and from where.

Zenoh (1.10.2) tells of them in its log alone, which goes to standard output, and tells the reason but not the address.
So standard output is read here; the addresses are those of the sockets that the operating system has just closed at
the listener's port, of which Zenoh has made no link.
"""

from __future__ import annotations

import os
import re
import sys
import threading
from collections import Counter
from collections.abc import Callable, Iterator
from ipaddress import ip_address
from pathlib import Path
from typing import TypeVar

_LOG = "off,zenoh_link_tls=warn"
_LINE = re.compile(rb"zenoh_link_tls::unicast\S*:\S* (?P<why>.*)\. Hint: increase the system open file limit")
_WHY = {
    "no certificate": "no certificate",
    "expired": "expired",
    "invalid peer certificate": "of another authority",
    "received fatal alert": "does not trust this router",
    "corrupt message": "no TLS",
    "eof": "broke off",
    "Timeout": "broke off",
}
"""By a part of Zenoh's words: the first that fits counts."""
_SOCKETS = ("/proc/net/tcp", "/proc/net/tcp6")
_ESTABLISHED, _LISTENING = "01", "0A"
_KNOWN = 1000
"""Of so many addresses it is remembered what became of them: a flood of them fills no memory."""
_SHOWN = 3
"""Newest addresses that are named."""
Address = tuple[str, int]
T = TypeVar("T")


class Refusals:
    """Counts what the log tells, from a thread of its own; made before Zenoh's first session.

    Args:
        port: that the router listens on.
        report: told of each reason and address that is new, one line.
    """

    def __init__(self, port: int, report: Callable[[str], None]) -> None:
        self._port, self._report = port, report
        self._why: Counter[str] = Counter()
        self._where: dict[str, None] = {}
        self._seen: dict[Address, None] = {}
        os.environ.setdefault("RUST_LOG", _LOG)
        log, writes = os.pipe()
        # What the user wants to see of Zenoh's log is passed on.
        self._rest = os.dup(sys.stdout.fileno())
        os.dup2(writes, sys.stdout.fileno())
        os.close(writes)
        threading.Thread(target=self._read, args=(log,), name="Zenoh's log", daemon=True).start()

    def accepted(self, link: str) -> None:
        """Zenoh has made a link with an address, such as ``tls/127.0.0.1:41000``."""
        host, _, port = link.partition("/")[2].partition("?")[0].rpartition(":")
        _keep(self._seen, (str(ip_address(host.strip("[]"))), int(port)))

    def __str__(self) -> str:
        """What was refused so far, in words; empty if nothing was."""
        if not self._why:
            return ""
        why = ", ".join(f"{reason} {count}" for reason, count in self._why.most_common())
        where = ", ".join([*self._where][-_SHOWN:])
        return f"refused connections: {self._why.total()} ({why})" + (f", seen from {where}" if where else "")

    def _read(self, log: int) -> None:
        with os.fdopen(log, "rb") as lines:
            for line in lines:
                if found := _LINE.search(line):
                    self._count(found["why"].decode(errors="replace"))
                else:
                    os.write(self._rest, line)

    def _count(self, words: str) -> None:
        why = next((short for part, short in _WHY.items() if part in words), words[:80])
        fresh = [address for address in closing(self._port) if address not in self._seen]
        for address in fresh:
            _keep(self._seen, address)
        where = dict.fromkeys(host for host, _ in fresh)
        new = why not in self._why or not where.keys() <= self._where.keys()
        self._why[why] += 1
        for host in where:
            _keep(self._where, host)
        if new:
            self._report(f"refused a connection{' from ' if where else ''}{', '.join(sorted(where))}: {why}")


def _keep(newest: dict[T, None], item: T) -> None:
    """Put something at the end of what is remembered, which is no more than it has to be."""
    newest.pop(item, None)
    newest[item] = None
    if len(newest) > _KNOWN:
        newest.pop(next(iter(newest)), None)


def closing(port: int) -> Iterator[Address]:
    """Who has, or had up to a minute ago, a connection to a port of this machine that one side has closed; on Linux."""
    for path in map(Path, _SOCKETS):
        try:
            rows = path.read_text().splitlines()[1:]
        except OSError:
            continue
        for _, local, remote, state, *_ in map(str.split, rows):
            if int(local.rpartition(":")[2], 16) == port and state not in (_ESTABLISHED, _LISTENING):
                host, _, other = remote.rpartition(":")
                yield _host(host), int(other, 16)


def _host(digits: str) -> str:
    """An address as people write it: the kernel prints each of its 32-bit words in the machine's own order."""
    words = (bytes.fromhex(digits[start : start + 8]) for start in range(0, len(digits), 8))
    packed = b"".join(word[::-1] if sys.byteorder == "little" else word for word in words)
    address = ip_address(packed)
    return str(getattr(address, "ipv4_mapped", None) or address)
