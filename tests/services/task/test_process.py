"""The task as a process over a real router: a carry, and the faults of one. What all keep is in ``tests/promises``."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from shared.topics import BASE_ENABLE, COMMAND_GRIPPER, CONTROL_TARGET, TASK_STATUS
from tests.conftest import Router, StartProcess
from tests.services.cli.command import tandem
from tests.services.task.surroundings import Surroundings
from tests.support.processes import Process
from tests.support.wait import eventually, throughout

pytestmark = [pytest.mark.processes, pytest.mark.timeout(400)]
# A loaded machine holds a process up for longer than a pose may be old. The task then waits and goes on; it gives up
# for what a test is about, and for nothing else.
FORGIVING = ("max_delay=1.0", "marker_max_age=1.0", "patience=60.0", "marker_patience=60.0")


@pytest.fixture
def around(shared_router: Router) -> Iterator[Surroundings]:
    with Surroundings(shared_router.endpoint) as surroundings:
        yield surroundings


@pytest.fixture
def task(shared_router: Router, start: StartProcess, tmp_path: Path) -> Process:
    return launch(shared_router, start, tmp_path)


def launch(router: Router, start: StartProcess, state: Path) -> Process:
    chosen = [f"--set={setting}" for setting in FORGIVING]
    environment = {"XDG_STATE_HOME": str(state)}
    return start("services.task", "--connect", router.endpoint, *chosen, environment=environment)


@pytest.mark.slow
def test_a_whole_carry(around: Surroundings, task: Process) -> None:
    around.leads = True
    around.begun("calibrating")
    around.says("done", within=200.0)
    states = list(dict.fromkeys(r.message.state for r in around.robot.received[TASK_STATUS.key]))
    assert states[-4:] == ["carrying", "releasing", "retreating", "done"]
    assert not around.robot.toy.gripped and task.running


def test_the_camera_rests_unless_the_marker_is_looked_for(around: Surroundings, task: Process) -> None:
    around.says("idle", "ready")
    throughout(lambda: not around.looked_at(), 0.5, "nobody looks before the start")
    around.carrying()
    assert around.pictured
    eventually(lambda: not around.looked_at(), message="no more looking once the panel is held")
    taken = around.pictured
    throughout(lambda: around.pictured == taken, 1.0, "no pictures while carrying")
    around.robot.toy.lifted = False
    around.ask("release")
    around.ask("release")
    around.says("done")
    assert around.pictured == taken
    around.ask("reset")
    around.begun("approaching")
    assert around.pictured > taken


def test_killed_and_restarted_while_carrying_it_goes_on_and_ended_it_keeps_the_panel(
    around: Surroundings, task: Process, shared_router: Router, start: StartProcess, tmp_path: Path
) -> None:
    around.carrying()
    toy = around.robot.toy
    toy.far_height = float(toy.tool.position[2]) - 0.1
    eventually(lambda: toy.tool.position[2] < toy.far_height + 0.03, 60.0, "it follows the person down")

    def journalled() -> bool:
        # Written once a second: a restart goes by it, and not by what the tool did since.
        kept = [json.loads(path.read_text()) for path in (tmp_path / "tandem" / "tiago" / "task").glob("*.json")]
        target = around.robot.last(CONTROL_TARGET)
        return any(np.allclose(entry["target"][:3], target.position, atol=0.01) for entry in kept)

    eventually(journalled, 60.0, "the journal")
    task.kill()
    before, killed = around.robot.last(CONTROL_TARGET), time.monotonic_ns()
    again = launch(shared_router, start, tmp_path)
    carries_on = around.says("carrying", "carrying;", since=killed)
    for target in around.targets(killed):
        assert np.allclose(target.position, before.position, atol=0.05)
        assert target.nominal_force == pytest.approx(before.nominal_force, abs=0.6)
    # Before, it may have waited for an input where the tool is.
    first = around.targets(carries_on.header.stamp)[0]
    assert first.position[:2] == pytest.approx(before.position[:2], abs=1e-9)
    grips = [r.message for r in around.robot.received[COMMAND_GRIPPER.key] if r.header.stamp >= killed]
    assert all(grip.opening == 0.0 for grip in grips)
    again.ends_in_time()
    eventually(lambda: not around.robot.last(BASE_ENABLE).enabled, message="the base is left standing")
    assert toy.gripped


def test_command_line(around: Surroundings, task: Process, shared_router: Router) -> None:
    around.says("idle", "ready")
    done = tandem("task", "abort", "--connect", shared_router.endpoint)
    assert done.returncode == 0 and done.stdout.startswith("abort: accepted, the task is holding")
    done = tandem("task", "start", "--connect", shared_router.endpoint)
    assert done.returncode == 1 and "task refused: start in state holding: `reset` first" in done.stderr
