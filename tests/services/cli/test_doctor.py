"""What `tandem doctor` finds on a machine, and what it says to do about it."""

from __future__ import annotations

import json
import os
import socket
from pathlib import Path

import pytest

from services.cli import doctor, memory
from services.cli.health import machine
from tests.services.cli.command import tandem_here
from tests.support.closed import make


def test_every_line_is_judged_and_what_is_not_well_has_a_remedy(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("TANDEM_SECURE", raising=False)
    done = tandem_here(capsys, "doctor", "--json")
    found = json.loads(done.stdout)
    checks = {one["check"] for one in found["checks"]}
    wanted = {"cores", "load", "clock", "port 7447", "port 9090", "disk", "Python", "packages", "film", "Docker", "ROS"}
    assert wanted | {"certificate", "stack"} <= checks
    for one in found["checks"]:
        assert bool(one["remedy"]) == (one["state"] != "ok"), one
    missing = any(one["state"] == "missing" for one in found["checks"])
    assert (done.returncode, found["good"]) == (int(missing), not missing)
    words = tandem_here(capsys, "doctor").stdout
    assert all(word in words for check in checks for word in check.split())


def test_a_busy_machine_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_getaffinity", lambda pid: {0, 1})
    monkeypatch.setattr(os, "getloadavg", lambda: (0.2, 0.0, 0.0))
    assert (machine.load().state, machine.cores().state) == ("ok", "ok")
    monkeypatch.setattr(os, "getloadavg", lambda: (1.4, 0.0, 0.0))
    assert machine.load().state == "warn" and machine.load().values == {"load_1min": 1.4}
    monkeypatch.setattr(os, "sched_getaffinity", lambda pid: {0})
    assert machine.cores().state == "warn"


def test_the_holder_of_a_port_is_named() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        number = taken.getsockname()[1]
        held = machine.port("router", number)
        assert held.state == "warn" and f"process {os.getpid()} (" in held.said and "--connect" in held.remedy
    free = machine.port("router", number)
    assert (free.state, free.values) == ("ok", {"port": number, "holder": None})


def test_a_disk_that_is_full_or_closed_is_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    assert machine.disk(tmp_path / "runs").values["free_MB"] > 0
    monkeypatch.setattr(machine, "SPACE", 1e12)
    assert machine.disk(tmp_path / "runs").state == "warn"
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    assert machine.disk(tmp_path / "runs").state == "missing"


def test_a_machine_that_draws_no_films_is_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    for name in ("VK_DRIVER_FILES", "VK_ICD_FILENAMES"):
        monkeypatch.delenv(name, raising=False)
    assert (machine.film([tmp_path]).state, machine.film([tmp_path / "none"]).state) == ("warn", "warn")
    (tmp_path / "lvp_icd.json").touch()
    assert machine.film([tmp_path]).said == "driver of Vulkan: lvp_icd.json"


@pytest.mark.parametrize(("extra", "state"), [("controller", "missing"), ("viewer", "warn")])
def test_what_only_some_need_is_no_reason_to_fail(extra: str, state: str) -> None:
    (found,) = doctor.extras(lambda asked: ["one"] if asked == extra else [])
    assert (found.state, found.remedy) == (state, f"pip install '.[{extra}]' in its checkout")
    assert f"one not installed, for {extra}" in found.said


def test_another_python_lacks_the_simulation_only() -> None:
    assert doctor.python((3, 11)).state == "ok"
    assert doctor.python((3, 13)).state == "warn"


@pytest.mark.parametrize(
    ("script", "state", "said"),
    [
        ("echo 27.0.1", "ok", "engine 27.0.1, compose 27.0.1"),
        ('[ "$1" = version ] && echo 27.0.1', "warn", "engine 27.0.1, compose is missing"),
        ("exit 1", "warn", "engine does not answer, compose is missing"),
        ("", "warn", "not installed"),
    ],
)
def test_docker(script: str, state: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if script:
        (tmp_path / "docker").write_text(f"#!/bin/sh\n{script}\n")
        (tmp_path / "docker").chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    found = doctor.docker()
    assert (found.state, found.said) == (state, said)


def test_ros_is_tried_where_it_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    with socket.socket() as master:
        master.bind(("127.0.0.1", 0))
        master.listen()
        monkeypatch.setenv("ROS_MASTER_URI", f"http://127.0.0.1:{master.getsockname()[1]}/")
        monkeypatch.setenv("ROS_DISTRO", "noetic")
        assert machine.ros().state == "ok"
    assert machine.ros().state == "warn" and "refused" in machine.ros().said
    monkeypatch.setenv("ROS_MASTER_URI", "nonsense")
    assert "http://HOST:11311" in machine.ros().remedy
    monkeypatch.delenv("ROS_MASTER_URI")
    monkeypatch.delenv("ROS_DISTRO")
    assert machine.ros().state == "ok"


def test_a_certificate_is_told_with_its_end(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    keys = make(tmp_path / "keys", "--only", "operator")
    old = make(tmp_path / "old", "--only", "operator", "--days", "0")
    for folder, state, said in (
        (keys / "operator", "ok", "tiago.operator in "),
        (old / "operator", "missing", "expired on 20"),
        (tmp_path / "none", "missing", "No such file"),
    ):
        monkeypatch.setenv("TANDEM_SECURE", str(folder))
        found = doctor.certificate("tiago")
        assert found.state == state and said in found.said


def test_stacks_are_told_and_those_left_behind(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    assert [one.said for one in machine.stacks()] == ["none of yours runs"]
    memory.keep("tiago", "tcp/127.0.0.1:1", {})
    assert [one.said for one in machine.stacks()] == ["robot tiago runs on tcp/127.0.0.1:1"]
    (path,) = tmp_path.rglob("*.json")
    path.write_text(json.dumps({"robot": "tiago", "endpoint": "tcp/127.0.0.1:1", "pid": 2**22 + 1}))
    (behind,) = machine.stacks()
    assert (behind.state, behind.remedy) == ("warn", f"rm {path}")
