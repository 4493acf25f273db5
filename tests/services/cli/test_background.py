"""A function in another process: its result, whatever becomes of it, and its end with the command."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from services.cli.background import Background, NoResult
from tests.services.cli.command import exists
from tests.support.processes import ROOT
from tests.support.wait import eventually

pytestmark = pytest.mark.processes

STARTER = """
import multiprocessing, pathlib, sys, threading, time
from services.cli.background import Background
work = Background(time.sleep, 60.0, log=pathlib.Path(sys.argv[1]), patience=60.0)
while not pathlib.Path(sys.argv[1]).exists():
    time.sleep(0.01)
print(multiprocessing.active_children()[0].pid, flush=True)
threading.Event().wait()
"""


def done(tmp_path: Path, function: Callable[..., Any], *arguments: Any, patience: float = 60.0) -> Any:
    work = Background(function, *arguments, log=tmp_path / "log", patience=patience)
    eventually(lambda: not work.busy, 60.0, "it is done")
    return work.result()


def test_what_it_returns_comes_back_and_what_it_prints_is_kept(tmp_path: Path) -> None:
    assert done(tmp_path, math.sqrt, 4.0) == 2.0
    done(tmp_path, os.system, "echo said")
    assert (tmp_path / "log").read_text() == "said\n"


@pytest.mark.parametrize(
    ("function", "argument", "patience", "says"),
    [
        (math.sqrt, -1.0, 60.0, "math domain error"),
        (os._exit, 3, 60.0, "ended with status 3, see .*log"),
        (time.sleep, 60.0, 0.5, "it took over 0 s"),
    ],
    ids=["raises", "ends", "hangs"],
)
def test_without_a_result_it_says_why(
    tmp_path: Path, function: Callable[..., Any], argument: float, patience: float, says: str
) -> None:
    with pytest.raises(NoResult, match=says):
        done(tmp_path, function, argument, patience=patience)


@pytest.mark.parametrize("end", [signal.SIGKILL, signal.SIGTERM])
def test_it_ends_when_the_command_is_killed(tmp_path: Path, end: signal.Signals) -> None:
    with subprocess.Popen(
        [sys.executable, "-c", STARTER, str(tmp_path / "log")], cwd=ROOT, stdout=subprocess.PIPE, text=True
    ) as starter:
        assert starter.stdout is not None
        pid = int(starter.stdout.readline())
        assert exists(pid)
        starter.send_signal(end)
    eventually(lambda: not exists(pid), 10.0, "the other process is gone")
