"""An HTTP server for pages that act on a robot: what it takes is bounded, and it answers nobody but its own pages.

A page of somebody else's in the same browser can send requests here. It cannot read an answer, set a header of its
own, or choose the header Host, which names what the browser was told to open. So a request must name this machine
(against names that an attacker lets point here), and what acts must come from a page that was served here.
"""

from __future__ import annotations

import http.server
import json
import socket
import socketserver
import sys
import threading
from collections.abc import Mapping
from contextlib import suppress
from http import HTTPStatus
from typing import Any, BinaryIO
from urllib.parse import urlsplit

from shared.loop.config import Misconfigured

NAMES = ("127.0.0.1", "localhost")
"""By which a browser may call this machine."""
OWN_HEADER = "X-Tandem"
"""What only a page of the same origin can send without being asked about it first."""
LARGEST_HEAD, LARGEST_BODY = 16 * 1024, 4 * 1024
"""Of a request [bytes]."""
MOST_CONNECTIONS, MOST_AT_WORK = 100, 60
"""Beyond the second number only what is urgent is taken up."""
PATIENCE = 5.0
"""Time [s] for a connection to go on."""


class _Bounded:
    """Reads lines of a request's head, and of its body what is asked for."""

    def __init__(self, file: BinaryIO) -> None:
        self._file, self._left = file, LARGEST_HEAD

    def readline(self, size: int = -1) -> bytes:
        line = self._file.readline(self._left + 1 if size < 0 else min(size, self._left + 1))
        self._left -= len(line)
        if self._left < 0:
            raise ConnectionAbortedError("the head of the request is too long")
        return line

    def read(self, size: int) -> bytes:
        return self._file.read(size)

    @property
    def closed(self) -> bool:
        return self._file.closed

    def close(self) -> None:
        self._file.close()


class GuardedServer(http.server.ThreadingHTTPServer):
    """Serves in threads of its own until it is closed; one request per connection.

    Args:
        host, port: to listen on; port 0 is any.
        handler: of its requests.

    Raises:
        Misconfigured: the port is taken or not to be had there.
    """

    daemon_threads = True
    block_on_close = False
    request_queue_size = 64

    def __init__(self, host: str, port: int, handler: type[Guarded]) -> None:
        self._lock = threading.Lock()
        self._open: set[socket.socket] = set()
        self._unread: dict[socket.socket, None] = {}
        self.at_work = threading.BoundedSemaphore(MOST_AT_WORK)
        try:
            super().__init__((host, port), handler)
        except (OSError, OverflowError) as problem:
            said = getattr(problem, "strerror", None) or str(problem)
            raise Misconfigured(f"the page on {host}:{port}: {said.lower()}; choose another port or address") from None
        threading.Thread(target=self.serve_forever, args=(0.1,), name=f"page {self.port}", daemon=True).start()

    def server_bind(self) -> None:
        """Without the question to a name server that the library asks here."""
        socketserver.TCPServer.server_bind(self)
        self.server_name, self.server_port = str(self.server_address[0]), int(self.server_address[1])

    @property
    def port(self) -> int:
        """That it listens on."""
        return self.server_port

    def process_request(self, request: Any, client_address: Any) -> None:
        """Take up a connection; of too many the oldest that has not asked anything yet goes."""
        with self._lock:
            full = len(self._open) >= MOST_CONNECTIONS
            oldest = next(iter(self._unread), None) if full else None
            if oldest is not None:
                del self._unread[oldest]
                _end(oldest)
            if not full or oldest is not None:
                self._open.add(request)
                self._unread[request] = None
        if full and oldest is None:
            self.shutdown_request(request)
        else:
            super().process_request(request, client_address)

    def asked(self, request: socket.socket) -> None:
        """A connection has asked something."""
        with self._lock:
            self._unread.pop(request, None)

    def close_request(self, request: Any) -> None:
        """Give a connection up."""
        with self._lock:
            self._open.discard(request)
            self._unread.pop(request, None)
        super().close_request(request)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A browser that goes away is no error; what else there is ends its own connection alone, and is told."""
        problem = sys.exception()
        if not isinstance(problem, OSError):
            print(f"viewer: the page failed: {problem!r}", file=sys.stderr, flush=True)

    def close(self) -> None:
        """End it, and every connection."""
        self.shutdown()
        self.server_close()
        with self._lock:
            for connection in self._open:
                _end(connection)


def _end(connection: socket.socket) -> None:
    with suppress(OSError):
        connection.shutdown(socket.SHUT_RDWR)


class Guarded(http.server.BaseHTTPRequestHandler):
    """Takes up what may be asked, and hands it to `get` and `post`."""

    timeout = PATIENCE
    server: GuardedServer
    said = b""
    """What a POST brings."""
    own_port = 0
    """Port by which the browser reaches this server."""
    urgent: tuple[str, ...] = ()
    """Paths that are taken up however much is at work."""

    def setup(self) -> None:
        """Bound what is read."""
        super().setup()
        self.rfile: Any = _Bounded(self.rfile)

    def parse_request(self) -> bool:
        """Read the head."""
        whole = super().parse_request()
        self.server.asked(self.connection)
        return whole

    def get(self, path: str) -> None:
        """Answer a request that changes nothing."""
        raise NotImplementedError

    def post(self, path: str) -> None:
        """Answer one that does; it comes from a page of this origin."""
        raise NotImplementedError

    def do_GET(self) -> None:
        """Let in what names this machine."""
        if self._named():
            self._take_up(self.get)

    def do_POST(self) -> None:
        """Let in what a page of this origin sends."""
        length = self.headers.get("Content-Length", "0")
        if not length.isdecimal() or int(length) > LARGEST_BODY:
            wanted = f"wanted a body of at most {LARGEST_BODY} bytes, with its length"
            return self.refuse(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, wanted)
        # Read in any case: an answer to whoever has not been heard out may get lost.
        self.said = self.rfile.read(int(length))
        if not self._named():
            return
        if self.headers.get("Origin") != f"http://{self.headers['Host']}":
            self.refuse(HTTPStatus.FORBIDDEN, "only the page that is served here may ask this")
        else:
            self._take_up(self.post)

    def _named(self) -> bool:
        try:
            called = urlsplit(f"//{self.headers.get('Host', '')}")
            name, self.own_port = called.hostname, called.port or 80
        except ValueError:
            name = None
        if name not in NAMES:
            self.refuse(
                HTTPStatus.FORBIDDEN,
                "this page is for browsers on its own machine, as http://127.0.0.1; from another one reach it through "
                "ssh -L, with both ports",
            )
        return name in NAMES

    def _take_up(self, work: Any) -> None:
        path = urlsplit(self.path).path
        if path in self.urgent:
            return work(path)
        if not self.server.at_work.acquire(blocking=False):
            return self.refuse(HTTPStatus.SERVICE_UNAVAILABLE, "too many requests at once")
        try:
            work(path)
        finally:
            self.server.at_work.release()

    def body(self) -> Mapping[str, Any] | None:
        """The map that a request brings; None after an answer that says why there is none."""
        try:
            content = json.loads(self.said)
        except (ValueError, RecursionError):
            content = None
        if not isinstance(content, dict):
            self.refuse(HTTPStatus.BAD_REQUEST, "wanted a map in JSON")
            return None
        return content

    def answer(
        self, content: bytes, kind: str, status: HTTPStatus = HTTPStatus.OK, headers: Mapping[str, str] | None = None
    ) -> None:
        """Send an answer, of which nobody else's page may show or keep anything."""
        self.send_response(status)
        said = {"Content-Type": kind, "Content-Length": str(len(content)), "Cache-Control": "no-store"}
        said |= {"X-Content-Type-Options": "nosniff", "Referrer-Policy": "no-referrer"}
        for name, value in (said | {"Connection": "close"} | dict(headers or {})).items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(content)

    def tell(self, content: Mapping[str, Any], status: HTTPStatus = HTTPStatus.OK) -> None:
        """Send a map."""
        self.answer(json.dumps(content, allow_nan=False).encode(), "application/json", status)

    def refuse(self, status: HTTPStatus, why: str) -> None:
        """Say why not."""
        self.tell({"ok": False, "said": why}, status)

    def version_string(self) -> str:
        """Nobody needs to know."""
        return "tandem"

    def log_message(self, format: str, *values: Any) -> None:
        """A page asks five times a second."""
