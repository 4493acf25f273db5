"""What the page takes and from whom, and that a stop gets through whatever else is asked."""

from __future__ import annotations

import json
import re
import socket
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, closing
from pathlib import Path

import pytest

from services.viewer.page import server
from services.viewer.page.guarded import LARGEST_BODY, LARGEST_HEAD, MOST_AT_WORK, MOST_CONNECTIONS
from services.viewer.page.server import PageServer
from shared.loop.config import Misconfigured
from tests.services.viewer.page.conftest import Browser, Noted
from tests.support.wait import eventually

STATIC = Path(__file__).parents[4] / "services" / "viewer" / "page" / "static"
STRANGE = ("evil.example:9090", "127.0.0.1.evil.example", "robot:9090", "", "[::1", "127.0.0.1:many", "2130706433")


@pytest.mark.parametrize(
    ("path", "kind"),
    [
        ("/", "text/html"),
        ("/hands", "text/html"),
        ("/page.css", "text/css"),
        *((f"/{name}.js", "text/javascript") for name in ("hands", "page", "talk")),
    ],
)
def test_its_files_are_served_and_nobody_may_frame_them(page: PageServer, path: str, kind: str) -> None:
    answer = Browser(page).get(path)
    assert answer.status == 200 and answer.headers["Content-Type"].startswith(kind)
    policy = dict(part.strip().split(" ", 1) for part in answer.headers["Content-Security-Policy"].split(";"))
    assert policy["default-src"] == policy["frame-ancestors"] == "'none'"
    assert policy["script-src"] == policy["connect-src"] == "'self'"
    assert answer.headers["Cache-Control"] == "no-store"


def test_no_file_names_another_machine_and_each_is_served(page: PageServer) -> None:
    for file in STATIC.iterdir():
        assert not re.search(rb"(https?:)?//[a-z]", file.read_bytes()), file
        assert file.name == "page.html" or Browser(page).get(f"/{file.name}").body == file.read_bytes()


def test_the_state_names_this_start_and_where_the_picture_is(page: PageServer) -> None:
    first, second = (json.loads(Browser(page).get("/state").body) for _ in range(2))
    assert first == second == {"run": first["run"], "robot": "tiago", "acts": True, "reads": "/proxy"}
    assert len(first["run"]) >= 12


def test_only_who_begins_to_look_waits_until_all_are_heard_again(
    page: PageServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun = time.monotonic()
    assert Browser(page).get("/state").status == 200
    assert time.monotonic() - begun >= server.HEARD_WITHIN
    monkeypatch.setattr(server, "HEARD_WITHIN", 3600.0)
    assert page.watched and Browser(page).get("/state").status == 200


@pytest.mark.parametrize("above", [False, True])
@pytest.mark.parametrize("host", STRANGE)
def test_whoever_calls_this_machine_by_another_name_gets_nothing(page: PageServer, host: str, above: bool) -> None:
    browser = Browser(page, above)
    for answer in (browser.get("/", Host=host), browser.post("/stop", Host=host, Origin=f"http://{host}")):
        assert answer.status == 403
        assert "ssh -L" in json.loads(answer.body)["said"] or "only the page" in json.loads(answer.body)["said"]


def test_localhost_is_this_machine_too(page: PageServer, noted: Noted) -> None:
    here = f"localhost:{page.port}"
    assert Browser(page).get("/", Host=here).status == 200
    assert Browser(page).post("/stop", Host=here, Origin=f"http://{here}").status == 200
    assert [path for path, _ in noted.asked] == ["/stop"]


@pytest.mark.parametrize(
    "headers",
    [
        {"Origin": ""},
        {"Origin": "null"},
        {"Origin": "http://evil.example"},
        {"Origin": "http://127.0.0.1:1"},
        {"Origin": "https://127.0.0.1"},
        {"X_Tandem": ""},
    ],
)
def test_a_page_of_somebody_else_does_nothing(page: PageServer, noted: Noted, headers: dict[str, str]) -> None:
    for path in ("/stop", "/task"):
        assert Browser(page).post(path, **headers).status == 403
    assert not noted.asked


def test_the_picture_s_origin_does_nothing_either(page: PageServer, noted: Noted) -> None:
    assert Browser(page).post("/stop", Origin=f"http://127.0.0.1:{page.port + 1}").status == 403
    assert Browser(page, above=True).post("/stop").status == 404
    assert not noted.asked


def test_an_action_is_given_what_was_sent_and_its_answer_sent_back(page: PageServer, noted: Noted) -> None:
    answer = Browser(page).post("/task", json.dumps({"command": "start"}).encode())
    assert json.loads(answer.body) == {"ok": True, "said": "done"}
    assert noted.asked == [("/task", {"command": "start"})]


@pytest.mark.parametrize("body", [None, b"{}", b"[1]", b"\xff", b"[" * LARGEST_BODY])
def test_a_stop_is_taken_whatever_comes_with_it(page: PageServer, noted: Noted, body: bytes | None) -> None:
    assert Browser(page).post("/stop", body).status == 200
    assert noted.asked == [("/stop", {})]


@pytest.mark.parametrize(
    ("body", "headers", "status"),
    [
        (b"[1]", {}, 400),
        (b"", {}, 400),
        (b"\xff", {}, 400),
        (b"[" * LARGEST_BODY, {}, 400),
        (None, {"Content_Length": str(LARGEST_BODY + 1)}, 413),
        (None, {"Content_Length": "-1"}, 413),
        (None, {"Content_Length": "many"}, 413),
    ],
)
def test_what_is_no_request_is_refused_in_words(
    page: PageServer, noted: Noted, body: bytes | None, headers: dict[str, str], status: int
) -> None:
    answer = Browser(page).post("/task", body, **headers)
    assert answer.status == status and "wanted" in json.loads(answer.body)["said"]
    assert not noted.asked


@pytest.mark.parametrize("path", ["/nowhere", "/../server.py", "/static/page.js", "//evil.example/", "/release"])
def test_there_is_nothing_else(page: PageServer, path: str) -> None:
    assert Browser(page).get(path).status == 404
    assert Browser(page).post(path).status == 404


def test_a_head_without_end_is_cut_off(page: PageServer) -> None:
    with socket.create_connection(("127.0.0.1", page.port), 30.0) as stranger:
        stranger.sendall(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX: " + b"x" * 2 * LARGEST_HEAD)
        assert not end_of(stranger)
    assert Browser(page).get("/").status == 200


def end_of(connection: socket.socket) -> bytes:
    try:
        return connection.recv(1)
    except ConnectionResetError:
        return b""


def test_a_stop_gets_through_while_all_else_hangs(page: PageServer, noted: Noted) -> None:
    noted.hung = "/task"
    with ThreadPoolExecutor(MOST_AT_WORK) as others:
        hanging = [others.submit(Browser(page).post, "/task") for _ in range(MOST_AT_WORK)]
        eventually(lambda: len(noted.asked) == MOST_AT_WORK, 30.0)
        assert Browser(page).get("/state").status == 503
        assert Browser(page).post("/stop", None).status == 200
        noted.go_on.set()
        assert {future.result().status for future in hanging} == {200}
    assert Browser(page).get("/state").status == 200


def test_a_stop_gets_through_whoever_holds_connections_and_says_nothing(page: PageServer, noted: Noted) -> None:
    with ExitStack() as held:
        for _ in range(2 * MOST_CONNECTIONS):
            held.enter_context(socket.create_connection(("127.0.0.1", page.port), 30.0))
        assert Browser(page).post("/stop", None).status == 200
    assert noted.asked == [("/stop", {})]


@pytest.mark.parametrize("offset", [0, 1])
def test_a_taken_port_is_told_in_one_line_and_the_other_one_given_back(small_picture: Path, offset: int) -> None:
    with closing(PageServer("127.0.0.1", 0, "rerun+http://127.0.0.1:9/proxy", lambda run: {})) as found:
        port = found.port
    with (
        socket.create_server(("127.0.0.1", port + offset)),
        pytest.raises(Misconfigured, match=rf"^the page on 127.0.0.1:{port + offset}: address already in use; choose"),
    ):
        PageServer("127.0.0.1", port, "rerun+http://127.0.0.1:9/proxy", lambda run: {})
    with socket.create_server(("127.0.0.1", port + 1 - offset)):
        pass


@pytest.mark.parametrize(("host", "port"), [("192.0.2.1", 0), ("nowhere.invalid", 0), ("127.0.0.1", 70_000)])
def test_an_address_that_is_not_to_be_had_is_told_in_one_line(small_picture: Path, host: str, port: int) -> None:
    with pytest.raises(Misconfigured, match=rf"^the page on {host}:{port}: .*; choose another port or address$"):
        PageServer(host, port, "rerun+http://127.0.0.1:9/proxy", lambda run: {})


def test_a_recording_can_only_be_looked_at(small_picture: Path, tmp_path: Path) -> None:
    recording = tmp_path / "carry.rrd"
    recording.write_bytes(b"RRF2" + bytes(200_000))
    with closing(PageServer("127.0.0.1", 0, recording, lambda run: {"run": run})) as page:
        state = json.loads(Browser(page).get("/state").body)
        assert (state["acts"], state["reads"]) == (False, "/run.rrd")
        assert Browser(page).post("/stop").status == 404
        assert Browser(page, above=True).get("/run.rrd").body == recording.read_bytes()


def test_after_its_end_nobody_listens(page: PageServer, noted: Noted) -> None:
    with socket.create_connection(("127.0.0.1", page.port), 30.0) as held:
        held.sendall(b"GET ")
        page.close()
        assert not end_of(held)
    for port in (page.port, page.port + 1):
        with pytest.raises(ConnectionRefusedError):
            socket.create_connection(("127.0.0.1", port), 30.0)
