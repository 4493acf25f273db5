"""A page whose actions note what they are asked, with a picture of three small files."""

from __future__ import annotations

import gzip
import http.client
import threading
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from services.viewer.page import rerun_files
from services.viewer.page.actions import Done
from services.viewer.page.server import PageServer

PROGRAM = b"\0asm" + bytes(100_000)


class Answer(NamedTuple):
    status: int
    headers: Mapping[str, str]
    body: bytes


class Noted:
    """Actions that are noted; those of ``hung`` wait until they may go on."""

    def __init__(self) -> None:
        self.asked: list[tuple[str, Mapping[str, Any]]] = []
        self.hung = ""
        self.go_on = threading.Event()
        self.by_path: dict[str, Callable[[Mapping[str, Any]], Done]] = {
            path: self._note(path) for path in ("/stop", "/task")
        }

    def _note(self, path: str) -> Callable[[Mapping[str, Any]], Done]:
        def note(asked: Mapping[str, Any]) -> Done:
            self.asked.append((path, asked))
            if path == self.hung:
                self.go_on.wait(60.0)
            return Done(True, "done")

        return note


class Browser:
    """Sends what a browser would, and what none would.

    Args:
        page: that it has opened.
        above: it talks to the picture's port, the next one.
    """

    def __init__(self, page: PageServer, above: bool = False) -> None:
        self.port = page.port + int(above)
        self.host = f"127.0.0.1:{self.port}"

    def get(self, path: str, **headers: str) -> Answer:
        return self._ask("GET", path, None, {"Host": self.host, **headers})

    def post(self, path: str, body: bytes | None = b"{}", **headers: str) -> Answer:
        own = {"Host": self.host, "Origin": f"http://{self.host}", "X-Tandem": "page"}
        # An underscore for what a keyword cannot say; an empty value leaves a header out.
        chosen = own | {name.replace("_", "-"): value for name, value in headers.items()}
        return self._ask("POST", path, body, {name: value for name, value in chosen.items() if value})

    def _ask(self, method: str, path: str, body: bytes | None, headers: Mapping[str, str]) -> Answer:
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=30.0)
        try:
            connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
            for name, value in headers.items():
                connection.putheader(name, value)
            if method == "POST" and "Content-Length" not in headers:
                connection.putheader("Content-Length", str(len(body or b"")))
            connection.endheaders(body)
            reply = connection.getresponse()
            return Answer(reply.status, dict(reply.headers), reply.read())
        finally:
            connection.close()


@pytest.fixture
def small_picture(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with files in place of rerun's."""
    folder = tmp_path / "rerun-0"
    folder.mkdir()
    (folder / rerun_files.INDEX).write_text("<title>picture</title>")
    for name, content in ((rerun_files.SCRIPT, b"draw()"), (rerun_files.PROGRAM, PROGRAM)):
        (folder / f"{name}.gz").write_bytes(gzip.compress(content))
        (folder / f"{name}.size").write_text(str(len(content)))
    monkeypatch.setattr(rerun_files, "files", lambda: folder)
    return folder


@pytest.fixture
def noted() -> Noted:
    return Noted()


@pytest.fixture
def page(small_picture: Path, noted: Noted) -> Iterator[PageServer]:
    """A page of a picture that is nowhere."""
    made = PageServer(
        "127.0.0.1",
        0,
        "rerun+http://127.0.0.1:9/proxy",
        lambda run: {"run": run, "robot": "tiago"},
        noted,  # type: ignore[arg-type]
    )
    yield made
    noted.go_on.set()
    made.close()
