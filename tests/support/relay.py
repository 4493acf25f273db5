"""A socket between two processes that a test can cut in either direction."""

from __future__ import annotations

import contextlib
import itertools
import socket
import threading
from collections.abc import Callable, Iterable
from pathlib import Path
from tempfile import TemporaryDirectory

_CHUNK = 65536
_LOOK = 0.05  # [s] between two looks whether to end


class Relay:
    """Hands on what comes in at one socket to another, and back.

    What is withheld is lost with the connection, as on a network that was cut: neither end is told.

    Attributes:
        there, back: whether what is sent to ``to``, or by it, is handed on.
        dialled: how many connections were made.
    """

    def __init__(self, at: Path, to: Path) -> None:
        self.there = self.back = True
        self.dialled = 0
        self._to = to
        self._end = threading.Event()
        self._listener = socket.socket(socket.AF_UNIX)
        self._listener.bind(str(at))
        self._listener.listen()
        self._listener.settimeout(_LOOK)
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self) -> None:
        while not self._end.is_set():
            with contextlib.suppress(OSError):
                near, _ = self._listener.accept()
                far = socket.socket(socket.AF_UNIX)
                try:
                    far.connect(str(self._to))
                except OSError:
                    near.close()
                    continue
                self.dialled += 1
                for source, sink, passes in ((near, far, lambda: self.there), (far, near, lambda: self.back)):
                    threading.Thread(target=self._hand_on, args=(source, sink, passes), daemon=True).start()

    def _hand_on(self, source: socket.socket, sink: socket.socket, passes: Callable[[], bool]) -> None:
        source.settimeout(_LOOK)
        with contextlib.suppress(OSError):
            while not self._end.is_set():
                try:
                    data = source.recv(_CHUNK)
                except TimeoutError:
                    continue
                if not data:
                    break
                if passes():
                    sink.sendall(data)
        source.close()
        sink.close()

    def close(self) -> None:
        """End all connections."""
        self._end.set()
        self._listener.close()


class Crossings:
    """Relays between all of some processes, each of which meets the others in a folder of its own.

    Args:
        names: of the processes in the chain.

    Attributes:
        patterns: for ``--links`` of each.
    """

    def __init__(self, names: Iterable[str]) -> None:
        # A socket's path has to be short, and pytest's folders are not.
        self._folder = TemporaryDirectory()
        folders = {name: Path(self._folder.name) / name for name in names}
        for folder in folders.values():
            folder.mkdir()
        self.patterns = {name: f"unixsock-stream/{folder}/{{name}}.sock" for name, folder in folders.items()}
        self._relays = {
            (one, other): Relay(folders[one] / f"{other}.sock", folders[other] / f"{other}.sock")
            for one, other in itertools.permutations(folders, 2)
        }

    def cut(self, source: str, sink: str, passes: bool = False) -> None:
        """Withhold what one process sends to another, whoever dialled, or hand it on again."""
        self._relays[source, sink].there = passes
        self._relays[sink, source].back = passes

    @property
    def dialled(self) -> int:
        """How many connections were made."""
        return sum(relay.dialled for relay in self._relays.values())

    def close(self) -> None:
        """End all connections."""
        for relay in self._relays.values():
            relay.close()
        self._folder.cleanup()
