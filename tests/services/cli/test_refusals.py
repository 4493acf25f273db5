"""What the command cannot take is refused with one line that names it, and exit status 2."""

from __future__ import annotations

import re
import shutil
import socket
from pathlib import Path

import pytest

from tests.services.cli.command import tandem_here
from tests.support.ports import free_endpoint


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["hold", "0.5", "-0.3", "1", "0", "0", "0", "--force-limit", "-3"], r"force_limit is \[-3.*above 0 N"),
        (["hold", "0.5", "-0.3", "1"], "six numbers.*got 3"),
        (["hold", "0", "0", "1", "0", "0", "0", "--torque-limit", "1,2"], "--torque-limit '1,2'.*one number or three"),
        (["up", "--set", "law=1"], "--set 'law=1': wanted SERVICE.NAME=VALUE"),
        (["up", "--set", "viewer.x=1"], "'viewer' is no service of the stack"),
        (["up", "--with", "sim"], "--with 'sim': choose from base, task"),
        (["up", "--config", "/nowhere.toml"], "--config /nowhere.toml: No such file"),
        (["up", "--connect", "udp/127.0.0.1:1"], "wanted tcp/HOST:PORT"),
        (
            ["start", "viewer"],
            "'viewer' is no service of the stack; choose from router, sim, wrench, controller, base, task",
        ),
        (["task"], "Missing argument"),
        (["status", "--connect", "nonsense"], "--connect nonsense"),
        (["status", "--robot", "a/b"], "--robot 'a/b'"),
        (["topic", "echo", "no/such"], "'no/such' is no topic of the contract"),
        (["param", "set", "controller"], "wanted SERVICE.NAME=VALUE"),
        (["param", "set", "viewer.x=1"], "'viewer' has no parameters"),
        (["param", "set", "controller.law=[1"], "is no TOML value"),
        (["run", "load", "--runs", "nope"], "no run 'nope'; choose from paper-30"),
        (["run", "carry", "--law", "nope"], "no run 'nope-omni'; choose LAW-BASE"),
        (["run", "carry", "--base", "omni", "--no-base"], "--no-base and --base omni: choose one"),
        (["run", "carry", "--runs", "paper-omni", "--law", "paper"], "--runs names whole runs"),
        (["up", "--carry", "--config", "mine.toml"], "--carry and --config mine.toml: choose one"),
        (["hand", "0.5", "-0.3"], "hand 0.5 -0.3: wanted X Y Z in m"),
        (["hand", "none.toml"], "hand: none.toml: No such file"),
        (["fault", "lidar", "off"], "target is 'lidar', wanted one of ft, camera, joints"),
        (["fault", "ft"], "kind is '', wanted one of off"),
        (["fault", "ft", "bias", "much"], "value 'much': wanted a number"),
        (["fault", "ft", "off", "3"], "fault ft off 3: off takes no value"),
        (["view", "--beside", "b.mcap"], "--beside b.mcap: beside which recording"),
        (["view", "nowhere.mcap"], "nowhere.mcap: not there"),
        (["view", "tests", "--beside", "nowhere.mcap"], "nowhere.mcap: not there"),
        (["export", "a.mcap", "--csv", "/dev/null/deep"], "--csv /dev/null/deep: /dev/null is no folder"),
        (["export", "a.mcap", "--foxglove", "/dev/null/b.mcap"], "--foxglove /dev/null: /dev/null is no folder"),
        (["fly"], "No such command 'fly'"),
        (["topic"], "Missing command"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else None,
)
def test_refused_with_one_line(arguments: list[str], reason: str, capsys: pytest.CaptureFixture[str]) -> None:
    done = tandem_here(capsys, *arguments)
    assert done.returncode == 2
    assert done.stdout == ""
    assert re.search(reason, done.stderr)
    assert done.stderr.startswith("tandem: ")
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize("command", [["up"], ["run", "load"]], ids=["up", "run"])
def test_a_taken_port_is_named_with_another_choice(
    command: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        out = ["--out", str(tmp_path)] if command[0] == "run" else []
        done = tandem_here(capsys, *command, "--connect", f"tcp/127.0.0.1:{port}", *out)
    assert done.returncode == 1
    assert f"port {port} on 127.0.0.1" in done.stderr
    assert f"--connect tcp/127.0.0.1:{port + 1}" in done.stderr
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize("command", [("run", "load"), ("record",)], ids=" ".join)
def test_a_place_that_cannot_be_written_or_is_too_small_is_said_before_anything_runs(
    command: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "file"
    file.touch()
    place = ("--connect", free_endpoint(), "--out")
    taken = tandem_here(capsys, *command, *place, str(file / "deep"))
    assert taken.stderr == f"tandem: --out {file}/deep: {file} is no folder; choose another folder\n"
    monkeypatch.setattr("os.access", lambda path, mode: False)
    closed = tandem_here(capsys, *command, *place, str(tmp_path / "new" / "deep"))
    assert f"--out {tmp_path}/new/deep: {tmp_path} cannot be written" in closed.stderr
    monkeypatch.undo()
    monkeypatch.setattr("shutil.disk_usage", lambda path: shutil._ntuple_diskusage(10**9, 10**9 - 10**7, 10**7))
    small = tandem_here(capsys, *command, *place, str(tmp_path / "new" / "deep"))
    assert ": 10 MB are free there, " in small.stderr
    assert [done.returncode for done in (taken, closed, small)] == [2, 2, 2]
    assert list(tmp_path.iterdir()) == [file]


@pytest.mark.parametrize("command", [["status"], ["topic", "hz"], ["tare"], ["param", "get", "controller"]])
def test_without_a_router_says_how_to_start_one(command: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    done = tandem_here(capsys, *command, "--connect", free_endpoint())
    assert done.returncode == 1
    assert "no router at" in done.stderr
    assert "tandem up" in done.stderr
    assert done.stderr.count("\n") == 1
