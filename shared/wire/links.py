"""Direct links between the processes of one robot's chain: where each listens, and whom it dials.

Peers of one router that have no link of their own exchange nothing, so every process of the chain dials every other one
at an endpoint that follows from its name, and dials it again whenever the link is lost. Whoever is no part of the chain
is a client of the router.
"""

from __future__ import annotations

import hashlib
import os
import stat
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

SOCKETS = "sockets"
"""In place of a pattern: sockets in a folder of the user's, for processes on one machine."""
NONE = "none"
"""In place of a pattern: no links."""
_NAME = "{name}"
_FOLDER = Path("/tmp")  # whatever TMPDIR says: processes that differ in it would not find each other
_LOOPBACK = ("tcp/127.", "tcp/localhost:", "tcp/[::1]:")


class NoLinks(ValueError):
    """The links cannot be made as asked; the text is one line for the user."""


@dataclass(frozen=True)
class Links:
    """Direct links of one process.

    Attributes:
        own: its name in the chain.
        names: of all processes of the chain, its own among them.
        pattern: Zenoh endpoint with ``{name}`` in place of a process' name.
    """

    own: str
    names: tuple[str, ...]
    pattern: str

    @property
    def listen(self) -> str:
        """Endpoint on which it is dialled."""
        return self.pattern.replace(_NAME, self.own)

    @property
    def others(self) -> tuple[str, ...]:
        """Names of every other process of the chain."""
        return tuple(name for name in self.names if name != self.own)

    @property
    def dial(self) -> tuple[str, ...]:
        """Endpoints of the processes before it in the chain; those after it dial this one."""
        return tuple(self.pattern.replace(_NAME, name) for name in self.names[: self.names.index(self.own)])


def usual_links(router: str) -> str:
    """The links that a stack has unless it is told otherwise: sockets, if nobody elsewhere can reach its router."""
    return SOCKETS if router.startswith(_LOOPBACK) else NONE


def links_of(own: str, names: Sequence[str], pattern: str, robot: str, router: str) -> Links | None:
    """Direct links of a process; None if all that it says goes through the router.

    Args:
        own: name of the process in the chain.
        names: of all processes of the chain.
        pattern: endpoint with ``{name}``, ``sockets`` or ``none``.
        robot: first chunk of every key.
        router: endpoint of the router.

    Raises:
        NoLinks: the pattern names no process, the router is elsewhere or its network closed, or the folder belongs to
            somebody else.
    """
    if own not in names or pattern == NONE:
        return None
    if pattern != SOCKETS:
        if _NAME not in pattern:
            raise NoLinks(
                f"--links {pattern}: wanted an endpoint with {_NAME}, such as tcp/{_NAME}:7448, or {SOCKETS} or {NONE}"
            )
        return Links(own, tuple(names), pattern)
    if not router.startswith(_LOOPBACK):
        raise NoLinks(
            f"--links {SOCKETS}: they are for one machine without certificates, and the router is at {router}. "
            f"Choose an endpoint with {_NAME}, such as {router.partition('/')[0]}/{_NAME}:7448, or {NONE}"
        )
    address = router.partition("/")[2]
    # A socket's path has to be short, and its folder the same however the router's address was written.
    port = address.partition("?")[0].partition("#")[0].rpartition(":")[2]
    host = "" if router.startswith(_LOOPBACK[1:]) else address.partition(":")[0].removeprefix("127.0.0.1")
    place = hashlib.blake2s(f"{robot} {host}:{port}".encode(), digest_size=6).hexdigest()
    return Links(own, tuple(names), f"unixsock-stream/{_own_folder(place)}/{_NAME}.sock")


def _own_folder(place: str) -> Path:
    """A folder that nobody but this user can enter."""
    folder = _FOLDER / f"tandem-{os.getuid()}"
    folder.mkdir(mode=0o700, exist_ok=True)
    found = folder.lstat()
    if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.getuid() or found.st_mode & 0o077:
        raise NoLinks(f"{folder}: wanted a folder of this user's that nobody else can enter; move it away")
    (folder / place).mkdir(exist_ok=True)
    return folder / place
