"""The command as a user runs it, and the processes of the stack that it starts."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from services.cli.main import app
from tests.support.processes import ROOT


def tandem(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "services.cli", *arguments],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )


def tandem_here(capsys: pytest.CaptureFixture[str], *arguments: str) -> subprocess.CompletedProcess[str]:
    """The command in this process, which takes a hundredth of the time."""
    capsys.readouterr()
    with pytest.raises(SystemExit) as ended:
        app(arguments)
    printed = capsys.readouterr()
    return subprocess.CompletedProcess(arguments, int(ended.value.code or 0), printed.out, printed.err)


def pids(endpoint: str) -> dict[str, int]:
    """The stack's processes by service, found by their endpoint."""
    listed = subprocess.run(
        ["ps", "-eww", "-o", "pid=", "-o", "args="], capture_output=True, text=True, check=True
    ).stdout
    found = re.findall(rf"^\s*(\d+) \S+ -m services\.(\w+) .*{re.escape(endpoint)}", listed, re.MULTILINE)
    return {name: int(pid) for pid, name in found if name != "cli"}


def exists(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return "State:\tZ" not in Path(f"/proc/{pid}/status").read_text()
