"""rerun's page with what it draws, on a port of its own: for the browser another origin than the page that acts.

It is 43 MB of foreign code: from here it can read what is drawn, and nothing else. The page that frames it calls this
machine by its other name: that makes it another site, which has a thread of its own in the browser, so that a picture
that is slow to draw holds up neither the sentence nor STOP. What is drawn comes from the server inside this process, of
which one call is handed on: that server would take drawings from everybody, and does not ask what it is called.
"""

from __future__ import annotations

import selectors
import socket
from contextlib import suppress
from http import HTTPStatus
from pathlib import Path
from urllib.parse import urlsplit

from services.viewer.page import rerun_files
from services.viewer.page.guarded import NAMES, PATIENCE, Guarded, GuardedServer
from shared.loop.config import Misconfigured

READ = "/rerun.sdk_comms.v1alpha1.MessageProxyService/ReadMessages"
"""The call by which a browser reads what is drawn."""
RECORDING = "/run.rrd"
_PIECE = 64 * 1024
_POLICY = (
    "default-src 'self'; script-src 'self' 'unsafe-inline' 'wasm-unsafe-eval'; style-src 'self' 'unsafe-inline'; "
    "connect-src 'self'; worker-src 'self' blob:; img-src 'self' blob: data:; base-uri 'none'; form-action 'none'; "
    "frame-ancestors {pages}"
)


class Picture(GuardedServer):
    """Serves rerun's page.

    Args:
        host, port: to listen on; a browser expects the page that frames it one port below.
        source: address of a drawing of this machine (``rerun+http://127.0.0.1:PORT/proxy``), or a recording (.rrd).

    Raises:
        Misconfigured: the port is not to be had, or rerun's files are not.
    """

    def __init__(self, host: str, port: int, source: str | Path) -> None:
        self.recording = source if isinstance(source, Path) else None
        self.upstream = None if isinstance(source, Path) else _address(source)
        try:
            self.files = rerun_files.files()
        except rerun_files.Missing as problem:
            raise Misconfigured(str(problem)) from None
        super().__init__(host, port, _Handler)

    @property
    def reads(self) -> str:
        """Where the picture comes from, for the page in the browser: path and kind of its address."""
        return RECORDING if self.recording else "/proxy"


def _address(uri: str) -> tuple[str, int]:
    parts = urlsplit(uri)
    return parts.hostname or "127.0.0.1", parts.port or 0


class _Handler(Guarded):
    server: Picture

    def get(self, path: str) -> None:
        name = path.removeprefix("/") or rerun_files.INDEX
        if name == rerun_files.INDEX:
            policy = _POLICY.format(pages=" ".join(f"http://{name}:{self.own_port - 1}" for name in NAMES))
            page = (self.server.files / name).read_bytes()
            self.answer(page, "text/html; charset=utf-8", headers={"Content-Security-Policy": policy})
        elif name == rerun_files.SCRIPT:
            self._packed(name, "text/javascript")
        elif name == rerun_files.PROGRAM:
            self._packed(name, "application/wasm")
        elif path == RECORDING and self.server.recording:
            self._file(self.server.recording, "application/octet-stream", {})
        else:
            self.refuse(HTTPStatus.NOT_FOUND, "there is no such page")

    def _packed(self, name: str, kind: str) -> None:
        """A file that is kept packed; rerun's page shows its progress by the header that names the plain size."""
        folder = self.server.files
        tag = f'"{folder.name}"'
        kept = {"ETag": tag, "Cache-Control": "no-cache"}
        if self.headers.get("If-None-Match") == tag:
            return self.answer(b"", kind, HTTPStatus.NOT_MODIFIED, kept)
        size = (folder / f"{name}.size").read_text()
        self._file(folder / f"{name}.gz", kind, {"Content-Encoding": "gzip", "rerun-final-length": size, **kept})

    def _file(self, path: Path, kind: str, headers: dict[str, str]) -> None:
        """Send a file piece by piece: it is never in memory as a whole."""
        with path.open("rb") as file:
            self.send_response(HTTPStatus.OK)
            size = {"Content-Type": kind, "Content-Length": str(path.stat().st_size), "Connection": "close"}
            for name, value in (size | {"X-Content-Type-Options": "nosniff"} | headers).items():
                self.send_header(name, value)
            self.end_headers()
            while piece := file.read(_PIECE):
                self.wfile.write(piece)

    def post(self, path: str) -> None:
        """Hand on the one call, and its answer for as long as both ends last."""
        if path != READ or self.server.upstream is None:
            return self.refuse(HTTPStatus.NOT_FOUND, "there is no such call")
        kept = ("Content-Type", "Accept", "X-Grpc-Web", "X-User-Agent")
        said = [f"{name}: {value}" for name in kept if (value := self.headers.get(name))]
        said.append(f"Content-Length: {len(self.said)}")
        head = [f"POST {READ} HTTP/1.1", "Host: 127.0.0.1", "Connection: close", *said, "", ""]
        try:
            upstream = socket.create_connection(self.server.upstream, PATIENCE)
        except OSError:
            return self.refuse(HTTPStatus.BAD_GATEWAY, "what is drawn is not to be had")
        # A browser that draws slowly takes its time; whoever draws does not wait for it.
        self.connection.settimeout(None)
        upstream.settimeout(None)
        with upstream:
            upstream.sendall("\r\n".join(head).encode("latin-1") + self.said)
            self._hand_on(upstream)

    def _hand_on(self, upstream: socket.socket) -> None:
        with selectors.DefaultSelector() as either, suppress(OSError):
            either.register(upstream, selectors.EVENT_READ)
            either.register(self.connection, selectors.EVENT_READ)
            while True:
                # A browser has said everything: what it still sends is its end.
                ready = [key.fileobj for key, _ in either.select()]
                piece = upstream.recv(_PIECE) if self.connection not in ready else b""
                if not piece:
                    return
                self.connection.sendall(piece)
