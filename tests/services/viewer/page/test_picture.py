"""rerun's page on a port of its own, and the one call that is handed on to the server that draws."""

from __future__ import annotations

import gzip
import socket
import threading
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from services.viewer.page.picture import READ
from services.viewer.page.server import PageServer
from tests.services.viewer.page.conftest import PROGRAM, Browser
from tests.support.wait import eventually


def test_only_the_page_may_frame_it_and_it_may_talk_to_nobody_else(page: PageServer) -> None:
    answer = Browser(page, above=True).get("/")
    assert answer.body == b"<title>picture</title>"
    policy = answer.headers["Content-Security-Policy"]
    assert f"frame-ancestors http://127.0.0.1:{page.port} http://localhost:{page.port}" in policy
    assert "default-src 'self'" in policy and "connect-src 'self'" in policy and "http" not in policy.split("frame")[0]


def test_the_program_is_sent_packed_with_its_plain_size_and_only_once(page: PageServer) -> None:
    browser = Browser(page, above=True)
    answer = browser.get("/re_viewer_bg.wasm")
    assert answer.headers["Content-Encoding"] == "gzip" and answer.headers["Content-Type"] == "application/wasm"
    assert gzip.decompress(answer.body) == PROGRAM
    assert answer.headers["rerun-final-length"] == str(len(PROGRAM))
    again = browser.get("/re_viewer_bg.wasm", **{"If-None-Match": answer.headers["ETag"]})
    assert (again.status, again.body) == (304, b"")


class Upstream:
    """A server that draws: answers with what it is told to, piece by piece."""

    def __init__(self) -> None:
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.asked = b""
        self.answering: socket.socket | None = None
        self.thread = threading.Thread(target=self._serve)
        self.thread.start()

    @property
    def uri(self) -> str:
        return f"rerun+http://127.0.0.1:{self.listener.getsockname()[1]}/proxy"

    def _serve(self) -> None:
        connection, _ = self.listener.accept()
        while not self.asked.endswith(b"question"):
            self.asked += connection.recv(1000)
        self.answering = connection


@pytest.fixture
def upstream() -> Iterator[Upstream]:
    made = Upstream()
    yield made
    # Whoever was not asked is still waiting for it.
    with closing(made.listener), socket.create_connection(made.listener.getsockname()) as last:
        last.sendall(b"question")
        made.thread.join(30.0)


def asks(page: PageServer, path: str = READ) -> socket.socket:
    """A browser that has asked, of which the answer is read bit by bit."""
    here = f"127.0.0.1:{page.port + 1}"
    browser = socket.create_connection(("127.0.0.1", page.port + 1), 30.0)
    head = (f"POST {path} HTTP/1.1", f"Host: {here}", f"Origin: http://{here}", "Content-Length: 8", "X-Grpc-Web: 1")
    browser.sendall("\r\n".join((*head, "Cookie: secret", "", "question")).encode())
    return browser


def test_what_is_drawn_comes_as_it_is_drawn_until_the_browser_leaves(small_picture: Path, upstream: Upstream) -> None:
    with closing(PageServer("127.0.0.1", 0, upstream.uri, lambda run: {})) as page:
        with asks(page) as browser:
            source = eventually(lambda: upstream.answering)
            for piece in (b"HTTP/1.1 200 OK\r\n\r\n", b"picture"):
                source.sendall(piece)
                assert browser.recv(1000) == piece
        assert upstream.asked.startswith(f"POST {READ} HTTP/1.1\r\nHost: 127.0.0.1\r\n".encode())
        assert b"X-Grpc-Web: 1" in upstream.asked and b"secret" not in upstream.asked
        source.settimeout(30.0)
        assert source.recv(1) == b"", "the server that draws is let go, too"
        source.close()


@pytest.mark.parametrize("call", ["WriteMessages", "WriteTable", "ReadTables"])
def test_nobody_draws_from_outside(small_picture: Path, upstream: Upstream, call: str) -> None:
    with closing(PageServer("127.0.0.1", 0, upstream.uri, lambda run: {})) as page:
        with asks(page, READ.replace("ReadMessages", call)) as browser:
            assert b"404" in browser.recv(100)
        assert not upstream.asked


def test_a_picture_that_nobody_draws_is_told(page: PageServer) -> None:
    answer = Browser(page, above=True).post(READ, b"question")
    assert answer.status == 502 and b"not to be had" in answer.body
