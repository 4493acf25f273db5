"""The command ``tandem check-robot`` on each robot process: it passes, and moves nothing unasked."""

from __future__ import annotations

import io
import json
from subprocess import CompletedProcess
from typing import Any

import numpy as np
import pytest

from shared.topics import STATE_EE
from tests.conftest import Router
from tests.contract.robot import NAME, PATIENCE, Commander, Robot, RobotProcess
from tests.services.cli.command import tandem, tandem_here
from tests.support.wait import eventually

pytestmark = pytest.mark.processes


def _slow(said: str) -> bool:
    """Whether a row is what a simulation on a busy machine gets, and rightly: its pace, and the rates that follow."""
    return "of the wanted pace" in said or "Hz, wanted" in said


@pytest.fixture
def options(shared_router: Router) -> tuple[str, ...]:
    return ("--robot", NAME, "--connect", shared_router.endpoint)


def test_it_passes_and_moves_nothing_unasked(robot: Robot, kind: RobotProcess, options: tuple[str, ...]) -> None:
    robot.rests()
    start = robot.tool.position

    def passes() -> dict[str, Any]:
        # On a busy machine not every second is as it should be, but some are.
        done = tandem("check-robot", "--json", *options)
        said = json.loads(done.stdout)
        assert said["good"] == (done.returncode == 0)
        return said if all(row["good"] is not False or _slow(row["said"]) for row in said["checks"]) else {}

    checks = eventually(passes, PATIENCE, "it passes")["checks"]
    found = {row["what"]: row["good"] for row in checks if not _slow(row["said"])}
    assert found.pop("motion") is None
    assert (found.pop("sensor/camera"), found.pop("weight")) == ((True, True) if kind.world else (None, None))
    assert all(found.values())
    assert np.linalg.norm(robot.tool.position - start) < 2e-3
    assert not [name for name in robot.heard if name.startswith("command/")]


def test_with_consent_it_moves_little_and_passes(robot: Robot, options: tuple[str, ...]) -> None:
    robot.rests()
    start = robot.tool.position
    runs: list[CompletedProcess[str]] = []

    def passes() -> bool:
        runs.append(tandem("check-robot", "--move", "--base", "--yes", *options))
        refused = [line for line in runs[-1].stdout.splitlines() if line.startswith("NO") and not _slow(line)]
        return runs[-1].returncode in (0, 1) and not refused

    eventually(passes, PATIENCE, lambda: "it passes: " + "".join(run.stdout for run in runs))
    done = runs[-1]
    assert "The tool will move 10 mm" in done.stderr and "The base will move" in done.stderr
    for what in ("tool along x", "tool about z", "ttl", "second", "clamping", "garbage", "stop", "base turns"):
        assert f"ok  {what}: " in done.stdout
    way = max(np.linalg.norm(heard.message.position - start) for heard in robot.all(STATE_EE))
    assert way < 0.02 + 0.02 * len(runs)


def test_without_consent_nothing_moves(
    robot: Robot, options: tuple[str, ...], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    robot.rests()
    start = robot.tool.position
    monkeypatch.setattr("sys.stdin", io.StringIO("n\n"))
    assert tandem_here(capsys, "check-robot", "--move", *options).returncode == 1
    assert np.linalg.norm(robot.tool.position - start) < 2e-3


def test_a_stopped_robot_is_not_moved(robot: Robot, commander: Commander, options: tuple[str, ...]) -> None:
    commander.stop(True, "hand on the button")
    try:
        eventually(lambda: robot.status.mode == "stopped", PATIENCE, "the gate is stopped")
        done = tandem("check-robot", "--move", "--yes", *options)
    finally:
        commander.stop(False)
    assert done.returncode == 1
    # A busy machine has it name a rate, too.
    (line,) = (line for line in done.stdout.splitlines() if "motion: not tried: it is stopped" in line)
    assert line.startswith("NO") and "hand on the button" in line
    assert line.endswith("release it: tandem resume")


def test_nobody_there_is_said_in_a_second(shared_router: Router, capsys: pytest.CaptureFixture[str]) -> None:
    done = tandem_here(capsys, "check-robot", "--robot", "nobody", "--connect", shared_router.endpoint)
    assert done.returncode == 1
    assert "NO  sensor/ft: missing, listened for 1 s" in done.stdout
    assert "NO  robot: nothing is heard of it: is its process running" in done.stdout
