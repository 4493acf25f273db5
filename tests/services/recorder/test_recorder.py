"""The recorder as a process over a real router: all that is said, byte for byte, whatever ends it."""

from __future__ import annotations

import os
import signal
from contextlib import suppress
from pathlib import Path

import pytest

from services.recorder.topics import everything
from shared.topics import SENSOR_CAMERA, SENSOR_FT
from shared.wire.log import ABOUT, Log, NoRecording
from shared.wire.zenoh import ZenohBus
from tests.conftest import Router, StartProcess
from tests.support.ports import free_endpoint
from tests.support.processes import Process
from tests.support.wait import eventually

pytestmark = pytest.mark.processes


def recorded(out: Path) -> list[tuple[str, bytes]]:
    """All that can be read so far."""
    # A file that was just begun says nothing yet.
    with suppress(NoRecording):
        return [(entry.key, entry.payload) for file in sorted(out.glob("*.mcap")) for entry in Log(file)]
    return []


def recorder(start: StartProcess, router: Router, out: Path, *options: str) -> Process:
    process = start("services.recorder", "--connect", router.endpoint, "--out", str(out), *options)
    process.wait_for_output("recording")
    return process


def test_it_stands_back_and_so_do_the_threads_that_take_what_is_heard(
    shared_router: Router, start: StartProcess, tmp_path: Path
) -> None:
    process = recorder(start, shared_router, tmp_path)
    named = {
        int(path.parent.name): path.read_text().strip() for path in Path(f"/proc/{process.pid}/task").glob("*/comm")
    }
    zenoh = {thread for thread, name in named.items() if name.startswith(("app-", "tx-"))}
    assert zenoh
    for thread in {process.pid, *zenoh}:
        assert os.getpriority(os.PRIO_PROCESS, thread) >= 10, named[thread]
        assert os.sched_getscheduler(thread) == os.SCHED_BATCH, named[thread]


def say_until_heard(bus: ZenohBus, out: Path) -> None:
    """Say something under every key until each was recorded; what is no message is recorded like all else."""
    wanted = {(topic.key, topic.key.encode()) for topic in everything(camera=True)}

    def heard() -> bool:
        for key, payload in wanted:
            bus.publish(key, payload)
        return wanted <= set(recorded(out))

    eventually(heard, 30.0)


@pytest.mark.parametrize("end", [signal.SIGTERM, signal.SIGKILL])
def test_everything_is_recorded_whatever_ends_it(
    shared_router: Router, start: StartProcess, tmp_path: Path, end: signal.Signals
) -> None:
    process = recorder(start, shared_router, tmp_path)
    bus = ZenohBus(connect=shared_router.endpoint)
    say_until_heard(bus, tmp_path)
    bus.close()
    before = recorded(tmp_path)
    process.signal(end)
    status = process.wait()
    assert recorded(tmp_path)[: len(before)] == before
    (file,) = tmp_path.glob("*.mcap")
    assert Log(file).about[ABOUT]["robot"] == "tiago"
    if end == signal.SIGTERM:
        assert status == 0 and "messages" in process.output


def test_whoever_hears_nothing_is_told_what_to_do(shared_router: Router, start: StartProcess, tmp_path: Path) -> None:
    process = recorder(start, shared_router, tmp_path, "--robot", "nobody")
    process.wait_for_output("nothing was heard so far: does a robot of this name run there? See: tandem status")


def test_a_recording_that_is_there_is_not_gone_on_with(start: StartProcess, tmp_path: Path) -> None:
    """Its first files may be gone."""
    (tmp_path / "tiago-0003.mcap").write_bytes(b"of yesterday")
    process = start("services.recorder", "--connect", free_endpoint(), "--out", str(tmp_path))
    assert process.wait() == 2
    assert f"recorder: --out {tmp_path}: tiago-0003.mcap is there already; name another folder" in process.output


def test_without_the_camera_nobody_is_asked_for_pictures() -> None:
    assert {*everything(camera=True)} - {*everything(camera=False)} == {SENSOR_CAMERA}
    assert SENSOR_FT in everything(camera=False)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--most", "1"), ("--most 1: wanted 8 to 1000000 MB",)),
        (("--out", "/dev/null/x"), ("/dev/null/x", "Not a directory")),
    ],
)
def test_what_it_cannot_do_is_refused_in_one_line(
    start: StartProcess, options: tuple[str, ...], words: tuple[str, ...]
) -> None:
    start("services.recorder", *options).refuses(*words)
