"""A closed network for tests: certificates as `tandem keys` makes them, and sessions with them."""

from __future__ import annotations

import json
import shutil
import socket
import ssl
import time
from pathlib import Path

import zenoh

from services.cli.main import commands
from shared.wire.credentials import Credentials
from shared.wire.links import Links
from shared.wire.zenoh import ZenohBus
from tests.support.wait import eventually

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


def session(endpoint: str, folder: Path) -> zenoh.Session:
    """A client of Zenoh's own with the certificate of a folder, which asks no table what it may do."""
    config = zenoh.Config()
    settings = {"mode": "client", "connect/endpoints": [endpoint], "scouting/multicast/enabled": False}
    for key, value in (settings | Credentials(folder).settings()).items():
        config.insert_json5(key, json.dumps(value))
    return zenoh.open(config)


def strangers(keys: Path, folder: Path) -> dict[str, ssl.SSLContext]:
    """Who is not let in, by the router's word for it; their certificates go to a folder."""
    foreign = make(folder / "foreign", "--only", "operator") / "operator"
    shutil.copytree(keys / "authority", folder / "expired" / "authority")
    expired = make(folder / "expired", "--only", "operator", "--days", "0") / "operator"
    ended = Credentials(expired).own().ends + 1.0
    eventually(lambda: time.time() > ended, message="the second is over in which it still holds")
    found = {}
    for why, held in {"no certificate": None, "of another authority": foreign, "expired": expired}.items():
        context = found[why] = ssl._create_unverified_context()
        if held:
            context.load_cert_chain(held / "certificate.pem", held / "key.pem")
    return found


def refused(port: int, context: ssl.SSLContext) -> bool:
    """Whether a listener on loopback ends a connection by refusing its certificate."""
    with socket.create_connection(("127.0.0.1", port), 20.0) as plain:
        try:
            with context.wrap_socket(plain) as secured:
                secured.recv(1)
        except ssl.SSLError:
            return True
    return False
