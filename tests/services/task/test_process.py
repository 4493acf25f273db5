"""The task as a process over a real router: a carry, and with each fault that concerns it."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from services.task.geometry import Pose
from shared.messages import Stop
from shared.parameters import Refused
from shared.topics import (
    BASE_ENABLE,
    COMMAND_GRIPPER,
    CONTROL_TARGET,
    SENSOR_CAMERA,
    STOP,
    TASK_STATUS,
    WRENCH_EXTERNAL,
)
from tests.conftest import Router, StartProcess
from tests.services.cli.command import tandem
from tests.services.task.surroundings import Surroundings
from tests.services.task.toy import MARKER
from tests.support.ports import free_endpoint
from tests.support.processes import Process
from tests.support.wait import eventually, throughout

pytestmark = [pytest.mark.processes, pytest.mark.timeout(400)]
# A loaded machine holds a process up for longer than a pose may be old. The task then waits and goes on; it gives up
# for what a test is about, and for nothing else.
FORGIVING = {"max_delay": 1.0, "marker_max_age": 1.0, "patience": 60.0, "marker_patience": 60.0}


@pytest.fixture
def around(shared_router: Router) -> Iterator[Surroundings]:
    with Surroundings(shared_router.endpoint) as surroundings:
        yield surroundings


@pytest.fixture
def task(shared_router: Router, start: StartProcess, tmp_path: Path) -> Process:
    return launch(shared_router, start, tmp_path)


def launch(router: Router, start: StartProcess, state: Path, **settings: float) -> Process:
    chosen = [f"--set={name}={value}" for name, value in {**FORGIVING, **settings}.items()]
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


def test_health_and_liveliness(around: Surroundings, task: Process) -> None:
    around.says("idle", "ready")
    eventually(around.ok, message="health ok")
    assert "task" in around.bus.living()
    eventually(lambda: around.health.latest.message.loop_hz > 35.0, message="about fifty steps a second")


def test_the_camera_rests_unless_the_marker_is_looked_for(around: Surroundings, task: Process) -> None:
    around.says("idle", "ready")
    throughout(lambda: not around.looked_at(), 0.5, "nobody looks before the start")
    around.carrying()
    assert around.pictures
    eventually(lambda: not around.looked_at(), message="no more looking once the panel is held")
    taken = around.pictures
    throughout(lambda: around.pictures == taken, 1.0, "no pictures while carrying")
    around.robot.toy.lifted = False
    around.ask("release")
    around.ask("release")
    around.says("done")
    assert around.pictures == taken
    around.ask("reset")
    around.begun("approaching")
    assert around.pictures > taken


def test_camera_off_while_approaching(
    around: Surroundings, shared_router: Router, start: StartProcess, tmp_path: Path
) -> None:
    launch(shared_router, start, tmp_path, marker_patience=5.0)
    around.begun("approaching")
    around.robot.muted.add(SENSOR_CAMERA.key)
    waits = around.says("approaching", "waiting", "no image")
    rest = around.targets(waits.header.stamp)[0]
    where = Pose.of(rest.position, rest.orientation)
    assert any(tool.near(where, 1e-6, 1e-6) for tool in around.path), "it stays where it was"

    def at_rest() -> bool:
        return around.robot.toy.tool.near(where, 0.03, 0.1)

    eventually(at_rest, message="it has come to rest")
    throughout(at_rest, 1.0, "it does not move")
    around.says("holding", "no image")
    assert at_rest()
    targets = (Pose.of(t.position, t.orientation) for t in around.targets(waits.header.stamp))
    assert all(target.near(where, 0.03, 0.1) for target in targets)
    assert not any(r.message.opening == 0.0 for r in around.robot.received[COMMAND_GRIPPER.key])


def test_marker_jumps_while_approaching(around: Surroundings, task: Process) -> None:
    around.begun("approaching")
    now = time.monotonic_ns()
    around.robot.show(Pose(MARKER.position + np.array((0.0, 0.2, 0.0)), MARKER.rotation))
    around.says("approaching", "waiting", "marker", since=now)
    eventually(
        lambda: around.robot.last(CONTROL_TARGET).position[1] > -0.15,
        60.0,
        "it goes to where the panel is now",
    )


def test_wrong_marker_is_never_gone_to(around: Surroundings, task: Process) -> None:
    around.robot.number = 12
    around.begun("searching")
    around.says("searching", "seen 12, wanted 7")
    throughout(lambda: around.robot.state == "searching", 1.0)


def test_wrench_lost_while_carrying(
    around: Surroundings, shared_router: Router, start: StartProcess, tmp_path: Path
) -> None:
    launch(shared_router, start, tmp_path, patience=3.0)
    around.carrying()
    now = time.monotonic_ns()
    around.robot.muted.add(WRENCH_EXTERNAL.key)
    around.says("carrying", "waiting", "Is wrench running?", since=now)
    eventually(lambda: not around.robot.last(BASE_ENABLE).enabled, message="the base stands")
    around.says("holding", "wrench/external")
    assert around.robot.toy.gripped
    around.robot.muted.clear()

    def carries_on() -> bool:
        try:
            return around.ask("start") == "carrying"
        except Refused as refusal:
            assert "wrench/external" in str(refusal)
            return False

    eventually(carries_on, message="it carries on when asked")
    eventually(lambda: around.robot.last(BASE_ENABLE).enabled, message="the base follows again")


@pytest.mark.slow
def test_killed_and_restarted_while_carrying(
    around: Surroundings, task: Process, shared_router: Router, start: StartProcess, tmp_path: Path
) -> None:
    around.carrying()
    toy = around.robot.toy
    toy.far_height = float(toy.tool.position[2]) - 0.1
    eventually(lambda: toy.tool.position[2] < toy.far_height + 0.03, 60.0, "it follows the person down")

    def journalled() -> bool:
        # Written once a second: a restart goes by it, and not by what the tool did since.
        kept = [
            json.loads(path.read_text()) for path in (tmp_path / "tandem" / "tiago" / "task").glob("*.json")
        ]
        target = around.robot.last(CONTROL_TARGET)
        return any(np.allclose(entry["target"][:3], target.position, atol=0.01) for entry in kept)

    eventually(journalled, 60.0, "the journal")
    task.kill()
    before, killed = around.robot.last(CONTROL_TARGET), time.monotonic_ns()
    launch(shared_router, start, tmp_path)
    carries_on = around.says("carrying", "carrying;", since=killed)
    for target in around.targets(killed):
        assert np.allclose(target.position, before.position, atol=0.05)
        assert target.nominal_force == pytest.approx(before.nominal_force, abs=0.6)
    # Before, it may have waited for an input where the tool is.
    first = around.targets(carries_on.header.stamp)[0]
    assert first.position[:2] == pytest.approx(before.position[:2], abs=1e-9)
    grips = [r.message for r in around.robot.received[COMMAND_GRIPPER.key] if r.header.stamp >= killed]
    assert all(grip.opening == 0.0 for grip in grips)
    assert toy.gripped
    around.leads = True
    around.says("done", within=200.0)


def test_stop_abort_and_refusals(around: Surroundings, task: Process) -> None:
    around.says("idle", "ready")
    with pytest.raises(Refused, match="wanted one of start, abort, release, reset"):
        around.ask("dance")
    around.begun("approaching")
    around.client.publish(STOP, Stop(True, "hand in the way"))
    around.says("holding", "hand in the way")
    with pytest.raises(Refused, match="`reset` first"):
        around.ask("start")
    around.client.publish(STOP, Stop(False))
    around.says("holding", "`reset` begins anew")
    assert around.ask("reset") == "idle"
    around.begun("approaching")
    assert around.ask("abort") == "holding"


def test_command_line(around: Surroundings, task: Process, shared_router: Router) -> None:
    around.says("idle", "ready")
    done = tandem("task", "abort", "--connect", shared_router.endpoint)
    assert done.returncode == 0 and done.stdout.startswith("abort: accepted, the task is holding")
    done = tandem("task", "start", "--connect", shared_router.endpoint)
    assert done.returncode == 1 and "task refused: start in state holding: `reset` first" in done.stderr


def test_ends_on_sigterm_within_two_seconds(around: Surroundings, task: Process) -> None:
    around.carrying()
    task.ends_in_time()
    eventually(lambda: not around.robot.last(BASE_ENABLE).enabled, message="the base is left standing")
    assert around.robot.toy.gripped


def test_waits_for_a_router_that_starts_later(start: StartProcess, tmp_path: Path) -> None:
    endpoint = free_endpoint()
    process = start("services.task", "--connect", endpoint, environment={"XDG_STATE_HOME": str(tmp_path)})
    process.wait_for_output("waiting for a Zenoh router")
    start("services.router", "--listen", endpoint).wait_for_output("listening")
    with Surroundings(endpoint) as around:
        around.says("idle", "ready")


BAD = {
    "marker_id=50": ("marker_id", "0 to 49"),
    "marker_id=1.5": ("marker_id", "a whole number"),
    "force_limit=[10.0, 10.0, 0.0]": ("force_limit", "0.1 to 200 N"),
    "gripper_open=0.05": ("gripper_open", "panel_thickness"),
    'compensation="none"': ("compensation", "tare", "payload"),
    "bogus=1": ("bogus", "marker_size"),
}


@pytest.mark.parametrize("assignment", BAD)
def test_bad_configuration_is_one_line_with_status_2(start: StartProcess, assignment: str) -> None:
    start("services.task", "--set", assignment).refuses(*BAD[assignment])
