"""The stack that a user runs is found by commands that do not name it."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from services.cli import memory
from tests.services.cli.command import tandem_here
from tests.support.ports import free_endpoint


@pytest.fixture(autouse=True)
def apart(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.delenv("TANDEM_CONNECT", raising=False)


def test_it_is_known_as_long_as_its_command_runs(tmp_path: Path) -> None:
    memory.keep("tiago", "tcp/127.0.0.1:1", {"links": None})
    assert memory.running() == [("tiago", "tcp/127.0.0.1:1")]
    assert memory.kept("tiago", "tcp/127.0.0.1:1") == {
        "robot": "tiago", "endpoint": "tcp/127.0.0.1:1", "pid": os.getpid(), "links": None
    }  # fmt: skip
    (path,) = tmp_path.rglob("*.json")
    path.write_text(json.dumps(json.loads(path.read_text()) | {"pid": 2**22 + 1}))
    assert memory.running() == []
    path.write_text("{")
    assert memory.running() == [] and memory.kept("tiago", "tcp/127.0.0.1:1") is None
    memory.forget("tiago", "tcp/127.0.0.1:1")
    assert not path.exists()


def test_a_command_speaks_to_the_only_one_of_its_robot_unless_told_otherwise(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    mine, other, named = (free_endpoint() for _ in range(3))
    memory.keep("tiago", mine, {"config": None, "settings": {}})
    memory.keep("reem", other, {"config": None, "settings": {}})
    assert f"no router at {mine}" in tandem_here(capsys, "status").stderr
    assert f"no router at {other}" in tandem_here(capsys, "status", "--robot", "reem").stderr
    assert f"no router at {named}" in tandem_here(capsys, "status", "--connect", named).stderr
    monkeypatch.setenv("TANDEM_CONNECT", named)
    assert f"no router at {named}" in tandem_here(capsys, "status").stderr
