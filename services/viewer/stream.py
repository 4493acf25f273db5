"""Where a drawing goes: a server for browsers and native viewers on an address of one's own, or a file.

Whoever draws knows nothing of that, it is given a stream: live, recorded, test and file differ in this module alone.
"""

from __future__ import annotations

import socket
from pathlib import Path
from types import TracebackType
from typing import Any, Self, cast

import rerun as rr
import rerun.blueprint as rrb

from services.viewer.blueprint import layout
from shared.loop.config import Misconfigured

APPLICATION = "tandem"
MEMORY = "64MB"
"""What the server keeps for browsers that come later, about a minute; the oldest goes first."""


class Stream:
    """A recording stream with a server or a file behind it; a context manager that sends what is left.

    Attributes:
        rec: to draw into.
        uri: at which browsers and native viewers read it; empty for a file.
    """

    def __init__(self, rec: rr.RecordingStream, uri: str = "") -> None:
        self.rec, self.uri = rec, uri
        rec.set_log_time_enabled(False)

    @classmethod
    def served(cls, host: str, port: int, memory: str = MEMORY) -> Self:
        """One that is served, and keeps so much for whoever comes later.

        Raises:
            Misconfigured: the port is taken or not to be had there.
        """
        port = free(host, port)
        rec = rr.RecordingStream(APPLICATION)
        # The server starts by itself, keeps no more than it may, and never makes who draws wait.
        sink = rr.GrpcServerSink(host, port, server_memory_limit=memory)
        rec.set_sinks(sink, default_blueprint=layout())
        return cls(rec, sink.uri)

    @classmethod
    def written(cls, path: Path, views: rrb.Blueprint | None = None) -> Self:
        """One that goes to a file (.rrd), with the usual layout or another one."""
        rec = rr.RecordingStream(APPLICATION)
        rec.set_sinks(rr.FileSink(path), default_blueprint=views or layout(live=False))
        return cls(rec)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.rec.flush()
        self.rec.disconnect()


def below(rec: rr.RecordingStream, side: str) -> rr.RecordingStream:
    """The part of a stream below a path, so that two drawings go into one; the stream itself if the path is empty."""
    return cast(rr.RecordingStream, _Below(rec, side)) if side else rec


class _Below:
    def __init__(self, rec: rr.RecordingStream, side: str) -> None:
        self._rec, self._side = rec, side

    def log(self, path: str, *what: Any, **how: Any) -> None:
        self._rec.log(f"{self._side}/{path}", *what, **how)

    def send_columns(self, path: str, **what: Any) -> None:
        self._rec.send_columns(f"{self._side}/{path}", **what)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._rec, name)


def free(host: str, port: int) -> int:
    """The port, or any free one for 0; nothing that rerun starts says that its port is taken.

    Raises:
        Misconfigured: it is taken, or not to be had on this address.
    """
    try:
        with socket.create_server((host, port)) as probe:
            found: int = probe.getsockname()[1]
            return found
    except OSError as problem:
        raise Misconfigured(
            f"{host}:{port}: {(problem.strerror or str(problem)).lower()}; choose another port"
        ) from None
