"""A closed network for tests: certificates as `tandem keys` makes them, and sessions with them."""

from __future__ import annotations

import time
from pathlib import Path

from services.cli.main import commands
from shared.wire.credentials import Credentials
from shared.wire.links import Links
from shared.wire.zenoh import ZenohBus

DAY = 86400.0


def make(folder: Path, *options: str, seconds: float = 0.0) -> Path:
    """`tandem keys FOLDER OPTIONS`; the certificates live so long [s], or as long as usual."""
    days = ("--days", f"{seconds / DAY:.9f}") if seconds else ()
    commands(["keys", str(folder), *options, *days], standalone_mode=False)
    return folder


def enter(endpoint: str, folder: Path, links: Links | None = None, within: float = 20.0) -> ZenohBus:
    """A session with the certificate of a folder, once there is a router; waited for so long [s]."""
    deadline = time.monotonic() + within
    credentials = Credentials.of(str(folder))
    bus = ZenohBus("tiago", endpoint, lambda: time.monotonic() > deadline, links, credentials=credentials)
    bus.link()
    return bus
