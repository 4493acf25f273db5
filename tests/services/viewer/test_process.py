"""The viewer as a process over a real router: what is said is drawn, and said why; and recordings without a router."""

from __future__ import annotations

import json
import os
import re
import shutil
import urllib.request
from pathlib import Path

import pytest

from services.viewer.main import check_room
from services.viewer.page.picture import READ
from shared.loop.config import Misconfigured
from shared.wire.client import Client
from shared.wire.zenoh import ZenohBus
from tests.conftest import Router, StartProcess
from tests.services.viewer.messages import MESSAGES
from tests.services.viewer.test_recorded import record
from tests.support.processes import Process
from tests.support.wait import eventually

pytestmark = [pytest.mark.processes, pytest.mark.timeout(300)]

PATIENCE = 90.0  # [s]: the first viewer on a machine takes rerun's page out of its package


def page(process: Process) -> str:
    """Address of the page, once it is served."""
    process.wait_for_output("Ctrl-C ends it", PATIENCE)
    found = re.search(r"http://127.0.0.1:\d+/", process.output)
    assert found is not None
    return found[0]


def fetched(url: str) -> bytes:
    direct = urllib.request.build_opener(urllib.request.ProxyHandler({}))
    return bytes(direct.open(url, timeout=PATIENCE).read())


def picture(url: str, path: str) -> str:
    """Address of something beside the picture, one port above the page."""
    port = int(url.rstrip("/").rpartition(":")[2])
    return f"http://127.0.0.1:{port + 1}{path}"


def drawn(url: str, wanted: tuple[bytes, ...]) -> bool:
    """Whether what a browser would read of the drawing holds all of this, before it has read a lot."""
    call = urllib.request.Request(
        picture(url, READ),
        data=b"\0\0\0\0\0",
        headers={
            "Content-Type": "application/grpc-web+proto",
            "X-Grpc-Web": "1",
            "Origin": picture(url, "").rstrip("/"),
        },
    )
    direct = urllib.request.build_opener(urllib.request.ProxyHandler({}))
    with direct.open(call, timeout=PATIENCE) as answer:
        read = b""
        while len(read) < 20_000_000 and not all(part in read for part in wanted):
            read += answer.read1(1 << 16)
    return all(part in read for part in wanted)


def test_what_is_said_is_drawn_and_the_sentence_says_why(start: StartProcess, shared_router: Router) -> None:
    process = start("services.viewer", "--connect", shared_router.endpoint, "--port", "0")
    url = page(process)
    assert "nothing is heard of the robot" in json.loads(fetched(f"{url}state"))["sentence"]["text"]
    bus = ZenohBus(connect=shared_router.endpoint)
    client = Client(bus)

    def says() -> str:
        for topic, message in MESSAGES.items():
            client.publish(topic, message)
        return str(json.loads(fetched(f"{url}state"))["sentence"]["text"])

    eventually(lambda: says() == "held back by z force: 24.8 of 25 N", PATIENCE)
    # Entities of the scene, of the curves and of the robot's description.
    parts = (b"/world/base/tool/limits", b"/curves/wrench/fz", b"/tf/joints", b"/robot/tiago_dual")
    assert drawn(url, parts)
    # Nobody but who is on this machine reaches any of it.
    ports = {address for address in _listening(process.pid) if not address.startswith("0100007F:")}
    assert not ports
    bus.close()
    eventually(lambda: "no answer from" in json.loads(fetched(f"{url}state"))["sentence"]["text"], PATIENCE)
    assert os.getpriority(os.PRIO_PROCESS, process.pid) > 0
    process.ends_in_time()


def _listening(pid: int) -> list[str]:
    """Addresses on which a process listens, as the kernel writes them."""
    inodes = set()
    for link in Path(f"/proc/{pid}/fd").iterdir():
        try:
            inodes.add(os.readlink(link))
        except FileNotFoundError:
            continue
    rows = [line.split() for line in Path(f"/proc/{pid}/net/tcp").read_text().splitlines()[1:]]
    return [row[1] for row in rows if row[3] == "0A" and f"socket:[{row[9]}]" in inodes]


def test_a_recording_is_shown_without_a_router(start: StartProcess, tmp_path: Path) -> None:
    record(tmp_path / "run" / "a.mcap", 5.0, 2.0)
    process = start("services.viewer", "--recording", str(tmp_path / "run"), "--port", "0")
    url = page(process)
    state = json.loads(fetched(f"{url}state"))
    assert state["sentence"]["text"] == f"a recording: {tmp_path / 'run'}, 2 s" and not state["acts"]
    content = fetched(picture(url, state["reads"]))
    assert content.startswith(b"RRF2") and b"/curves/wrench/fz" in content
    process.ends_in_time()


def test_two_recordings_are_shown_beside_each_other(start: StartProcess, tmp_path: Path) -> None:
    one, other = record(tmp_path / "a.mcap", 5.0, 2.0), record(tmp_path / "b.mcap", 5.0, 1.0)
    process = start("services.viewer", "--recording", str(one), "--beside", str(other), "--port", "0")
    state = json.loads(fetched(f"{(url := page(process))}state"))
    assert state["sentence"]["text"] == f"a recording: {one} beside {other}, 2 s"
    content = fetched(picture(url, state["reads"]))
    assert b"/curves/wrench/fz" in content and b"/beside/curves/wrench/fz" in content
    process.ends_in_time()


def test_a_drawing_that_the_disk_has_no_room_for_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "tandem-view-1").mkdir()
    check_room(tmp_path / "tandem-view-1")
    monkeypatch.setattr("shutil.disk_usage", lambda path: shutil._ntuple_diskusage(10**9, 10**9 - 1000, 1000))
    with pytest.raises(Misconfigured, match=f"{tmp_path}: the disk is full, so not all is drawn"):
        check_room(tmp_path / "tandem-view-1")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--recording", "/none.mcap"), ("/none.mcap", "not there")),
        (("--recording", "{other}"), ("other.mcap", "no recording")),
        (("--connect", "here"), ("--connect here", "wanted <protocol>")),
        (("--robot", "a/b"), ("--robot 'a/b'", "letters, digits")),
        (("--listen", "192.0.2.1", "--recording", "{recording}"), ("192.0.2.1", "choose another")),
    ],
    ids=["no file", "no recording", "no endpoint", "no name", "no address"],
)
def test_what_it_cannot_do_is_refused_in_one_line(
    start: StartProcess, tmp_path: Path, options: tuple[str, ...], words: tuple[str, ...]
) -> None:
    recording = record(tmp_path / "a.mcap", 5.0, 0.1)
    other = tmp_path / "other.mcap"
    other.write_bytes(b"something else")
    given = [option.format(recording=recording, other=other) for option in options]
    process = start("services.viewer", *given)
    assert process.wait(PATIENCE) == 2
    (*_, line) = process.output.splitlines()
    assert line.startswith("viewer: ") and all(word in line for word in words)
