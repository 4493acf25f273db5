"""A package that is not installed is named in one line, with the extra that brings it."""

from __future__ import annotations

import subprocess
import sys

import pytest

from services.cli import extras
from tests.services.cli.command import tandem_here
from tests.support.ports import free_endpoint
from tests.support.processes import ROOT


@pytest.mark.parametrize(
    ("package", "used_by", "extra"),
    [
        ("typer", "", "cli"),
        ("piqp", "services.controller.laws.qp", "controller"),
        ("cv2", "services.task.main", "task"),
    ],
)
def test_the_extra_is_named_of_whose_package_is_missing(package: str, used_by: str, extra: str) -> None:
    use = f"import services.cli.main as command; command.app = lambda: __import__({used_by!r})" if used_by else ""
    code = f"import sys; sys.modules[{package!r}] = None\n{use}\nfrom services.cli.__main__ import main; main()"
    ended = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=60)
    assert (ended.returncode, ended.stdout) == (2, "")
    assert (
        ended.stderr == f"tandem: needs {package}, which is not installed: pip install '.[{extra}]' in its checkout\n"
    )


@pytest.mark.parametrize(
    ("command", "package", "line"),
    [
        (("up",), "piqp", "tandem: piqp not installed: pip install '.[controller,sim]' in its checkout\n"),
        (
            ("run", "load"),
            "matplotlib",
            "tandem: matplotlib not installed: pip install '.[experiment]' in its checkout\n",
        ),
        (
            ("replay", "nothing.mcap", "--into", "controller"),
            "piqp",
            "tandem: piqp not installed: pip install '.[controller]' in its checkout\n",
        ),
        (
            ("up", "--bridge", "bridge_ros2"),
            "rosbags",
            "tandem: rosbags not installed: pip install '.[bridge_ros2]' in its checkout\n",
        ),
        (
            ("up", "--carry"),
            "opencv-contrib-python-headless",
            "tandem: opencv-contrib-python-headless not installed: pip install '.[task]' in its checkout\n",
        ),
    ],
    ids=" ".join,
)
def test_what_processes_lack_is_said_before_they_start(
    command: tuple[str, ...],
    package: str,
    line: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(extras, "_installed", lambda name: name != package)
    connect = () if command[0] == "replay" else ("--connect", free_endpoint())
    done = tandem_here(capsys, *command, *connect)
    assert (done.returncode, done.stdout, done.stderr) == (2, "", line)
