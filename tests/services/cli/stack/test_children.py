"""Processes that the command starts end with it, whatever way it ends."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from services.cli.stack.children import Child, Children
from tests.services.cli.command import exists
from tests.support.ports import free_endpoint
from tests.support.processes import ROOT
from tests.support.wait import eventually

pytestmark = pytest.mark.processes

STARTER = """
import sys, threading
from services.cli.stack.children import Child
child = Child("router", ["--listen", sys.argv[1]])
print(child.pid, flush=True)
threading.Event().wait()
"""


@pytest.mark.parametrize("end", [signal.SIGKILL, signal.SIGTERM])
def test_a_child_ends_when_the_command_is_killed(end: signal.Signals) -> None:
    starter = subprocess.Popen(
        [sys.executable, "-c", STARTER, free_endpoint()], cwd=ROOT, stdout=subprocess.PIPE, text=True
    )
    assert starter.stdout is not None
    pid = int(starter.stdout.readline())
    eventually(lambda: exists(pid), 10, "the child runs")
    starter.send_signal(end)
    starter.wait(10)
    eventually(lambda: not exists(pid), 10, "the child is gone")
    starter.stdout.close()


def test_output_and_exit_status_are_kept(tmp_path: Path) -> None:
    heard: list[str] = []
    child = Child("router", ["--listen", "nonsense"], tmp_path / "log", heard.append)
    eventually(lambda: child.status is not None, 20, "the router refuses its option")
    assert child.how_it_ended().startswith("ended with status 2: router: ")
    assert "nonsense" in child.last_line
    assert heard == list(child.lines)
    assert (tmp_path / "log").read_text().splitlines() == heard


def test_all_children_end_with_the_block() -> None:
    with Children() as children:
        started = [children.start(Child("router", ["--listen", free_endpoint()])) for _ in range(2)]
        eventually(lambda: all("listening" in child.last_line for child in started), 20, "both routers listen")
    assert [child.status for child in started] == [0, 0]


def test_a_stopped_child_is_woken_to_end() -> None:
    with Children() as children:
        child = children.start(Child("router", ["--listen", free_endpoint()]))
        eventually(lambda: "listening" in child.last_line, 20, "the router listens")
        os.kill(child.pid, signal.SIGSTOP)
        started = time.monotonic()
        assert children.stop() == []
        assert child.status == 0
        assert time.monotonic() - started < 3.0
