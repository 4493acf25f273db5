"""The task as a process over a real router: a carry, and with each fault that concerns it."""

from __future__ import annotations

import json
import secrets
import signal
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from services.task.geometry import Pose
from shared.bus_zenoh import ZenohBus
from shared.client import Client
from shared.clock import SteadyClock
from shared.codec import encode
from shared.messages import Header, Stop
from shared.parameters import Refused
from shared.topics import (
    BASE_ENABLE,
    COMMAND_GRIPPER,
    CONTROL_TARGET,
    SENSOR_CAMERA,
    STOP,
    TASK_COMMAND,
    TASK_STATUS,
    WRENCH_EXTERNAL,
    health_topic,
)
from tests.conftest import Router, StartProcess
from tests.services.cli.test_refusals import tandem
from tests.services.task.robot import TICK, Robot
from tests.services.task.toy import MARKER
from tests.support.ports import free_endpoint
from tests.support.processes import Process
from tests.support.wait import eventually, throughout

# A shared machine may hold a process up for longer than the default delay; these tests are not about that.
FORGIVING = ("--set", "max_delay=1.0", "--set", "marker_max_age=1.0")


class Surroundings:
    """The toy robot in real time: publishes from a thread of its own, collects what the task says.

    Attributes:
        pictures: how many the camera has taken; it does so only while somebody subscribes.
    """

    def __init__(self, endpoint: str) -> None:
        self.bus = ZenohBus(connect=endpoint)
        self.client = Client(self.bus)
        self.robot = Robot(self.client.watch)
        self.health = self.client.watch(health_topic("task"))
        self.leads = False
        self.pictures = 0
        self._session = secrets.randbits(60)
        self._sequences: dict[str, int] = {}
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._publish)
        self._thread.start()

    def _publish(self) -> None:
        due, tick = time.monotonic(), 0
        while not self._ended.wait(max(0.0, due - time.monotonic())):
            due += TICK
            if self.leads:
                self.robot.person()
            for topic, message, valid in self.robot.tick(tick):
                if topic is SENSOR_CAMERA:
                    if not self.looked_at():
                        continue
                    self.pictures += 1
                sequence = self._sequences.get(topic.key, 0)
                self._sequences[topic.key] = sequence + 1
                header = Header(sequence, self._session, SteadyClock().now_ns(), valid)
                self.bus.publish(topic.key, encode(message, header))
            tick += 1

    def looked_at(self) -> bool:
        return self.bus.wanted(SENSOR_CAMERA.key)

    def close(self) -> None:
        self._ended.set()
        self._thread.join()
        self.bus.close()

    def ask(self, command: object) -> str:
        return self.client.ask(TASK_COMMAND, {"command": command}, timeout=10.0)["state"]

    def ready(self) -> bool:
        return self.robot.state == "idle" and "ready" in self.robot.reason

    def in_state(self, state: str, *words: str) -> Callable[[], bool]:
        return lambda: self.robot.state == state and all(word in self.robot.reason for word in words)

    def begun(self, state: str) -> None:
        """Start, and wait for a state."""
        eventually(self.ready, 30.0, "the task is ready")
        self.ask("start")
        eventually(self.in_state(state), 60.0, state)

    def carrying(self) -> None:
        self.begun("carrying")
        self.robot.toy.lifted = True
        eventually(self.in_state("carrying", "carrying;"), message="the panel is lifted")


@pytest.fixture
def around(shared_router: Router) -> Iterator[Surroundings]:
    surroundings = Surroundings(shared_router.endpoint)
    yield surroundings
    surroundings.close()


@pytest.fixture
def task(shared_router: Router, start: StartProcess, tmp_path: Path) -> Process:
    return launch(shared_router, start, tmp_path)


def launch(router: Router, start: StartProcess, state: Path) -> Process:
    environment = {"XDG_STATE_HOME": str(state)}
    return start("services.task", "--connect", router.endpoint, *FORGIVING, environment=environment)


@pytest.mark.slow
def test_a_whole_carry(around: Surroundings, task: Process) -> None:
    around.leads = True
    around.begun("calibrating")
    eventually(around.in_state("done"), 110.0, "done")
    states = list(dict.fromkeys(r.message.state for r in around.robot.received[TASK_STATUS.key]))
    assert states[-4:] == ["carrying", "releasing", "retreating", "done"]
    assert not around.robot.toy.gripped and task.running


def test_health_and_liveliness(around: Surroundings, task: Process) -> None:
    eventually(around.ready, 30.0)
    eventually(
        lambda: around.health.latest and around.health.latest.message.state == "ok", message="health ok"
    )
    assert "task" in around.bus.living()
    eventually(lambda: around.health.latest.message.loop_hz > 35.0, message="about fifty steps a second")


def test_the_camera_rests_unless_the_marker_is_looked_for(around: Surroundings, task: Process) -> None:
    eventually(around.ready, 30.0)
    throughout(lambda: not around.looked_at(), 0.5, "nobody looks before the start")
    around.carrying()
    assert around.pictures
    eventually(lambda: not around.looked_at(), message="no more looking once the panel is held")
    taken = around.pictures
    throughout(lambda: around.pictures == taken, 1.0, "no pictures while carrying")
    around.robot.toy.lifted = False
    around.ask("release")
    around.ask("release")
    eventually(around.in_state("done"), 30.0, "let go")
    assert around.pictures == taken
    around.ask("reset")
    around.ask("start")
    eventually(around.in_state("approaching"), 30.0, "the marker is found again")
    assert around.pictures > taken


def test_camera_off_while_approaching(around: Surroundings, task: Process) -> None:
    around.begun("approaching")
    around.robot.muted.add(SENSOR_CAMERA.key)
    eventually(around.in_state("approaching", "waiting", "no image"), message="it waits and says why")
    where = around.robot.toy.tool
    throughout(lambda: around.robot.toy.tool.near(where, 0.03, 0.1), 1.0, "it does not move")
    eventually(around.in_state("holding", "no image"), 20.0, "it gives up to holding")
    assert around.robot.toy.tool.near(where, 0.03, 0.1)
    assert not any(r.message.opening == 0.0 for r in around.robot.received[COMMAND_GRIPPER.key])


def test_marker_jumps_while_approaching(around: Surroundings, task: Process) -> None:
    around.begun("approaching")
    around.robot.shown = Pose(MARKER.position + np.array((0.0, 0.2, 0.0)), MARKER.rotation)
    eventually(around.in_state("approaching", "waiting", "marker"), message="it waits and says why")
    eventually(
        lambda: around.robot.last(CONTROL_TARGET).position[1] > -0.15,
        20.0,
        "it goes to where the panel is now",
    )


def test_wrong_marker_is_never_gone_to(around: Surroundings, task: Process) -> None:
    around.robot.number = 12
    around.begun("searching")
    eventually(around.in_state("searching", "seen 12, wanted 7"), message=around.robot.reason)
    throughout(around.in_state("searching"), 1.0)


def test_wrench_lost_while_carrying(around: Surroundings, task: Process) -> None:
    around.carrying()
    around.robot.muted.add(WRENCH_EXTERNAL.key)
    eventually(around.in_state("carrying", "waiting", "Is wrench running?"), message="it waits")
    eventually(lambda: not around.robot.last(BASE_ENABLE).enabled, message="the base stands")
    eventually(around.in_state("holding", "wrench/external"), message="it holds")
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
    eventually(lambda: toy.tool.position[2] < toy.far_height + 0.03, 20.0, "it follows the person down")
    eventually(lambda: list((tmp_path / "tandem" / "task").glob("*.json")), message="the journal")
    task.signal(signal.SIGKILL)
    task.wait()
    before = around.robot.last(CONTROL_TARGET)
    for received in around.robot.received.values():
        received.clear()
    launch(shared_router, start, tmp_path)
    eventually(around.in_state("carrying", "carrying;"), 30.0, "it carries on by itself")
    first = around.robot.received[CONTROL_TARGET.key][0].message
    assert np.allclose(first.position, before.position, atol=0.05)
    assert first.position[:2] == pytest.approx(before.position[:2], abs=1e-9)
    assert first.nominal_force == pytest.approx(before.nominal_force, abs=0.6)
    assert all(r.message.opening == 0.0 for r in around.robot.received[COMMAND_GRIPPER.key])
    assert toy.gripped
    around.leads = True
    eventually(around.in_state("done"), 80.0, "and finishes")


def test_stop_abort_and_refusals(around: Surroundings, task: Process) -> None:
    eventually(around.ready, 30.0)
    with pytest.raises(Refused, match="wanted start, abort, release or reset"):
        around.ask("dance")
    around.begun("approaching")
    around.client.publish(STOP, Stop(True, "hand in the way"))
    eventually(around.in_state("holding", "hand in the way"), message="it holds")
    with pytest.raises(Refused, match="`reset` first"):
        around.ask("start")
    around.client.publish(STOP, Stop(False))
    assert around.ask("reset") == "idle"
    around.begun("approaching")
    assert around.ask("abort") == "holding"


def test_command_line(around: Surroundings, task: Process, shared_router: Router) -> None:
    eventually(around.ready, 30.0)
    done = tandem("task", "abort", "--connect", shared_router.endpoint)
    assert (done.returncode, done.stdout) == (0, "task: holding\n")
    done = tandem("task", "start", "--connect", shared_router.endpoint)
    assert done.returncode == 1 and "task refused: start in state holding: `reset` first" in done.stderr


def test_ends_on_sigterm_within_two_seconds(around: Surroundings, task: Process) -> None:
    around.carrying()
    before = time.monotonic()
    task.signal(signal.SIGTERM)
    assert task.wait() == 0
    assert time.monotonic() - before < 2.0
    eventually(lambda: not around.robot.last(BASE_ENABLE).enabled, message="the base is left standing")
    assert around.robot.toy.gripped


def test_waits_for_a_router_that_starts_later(start: StartProcess, tmp_path: Path) -> None:
    endpoint = free_endpoint()
    process = start("services.task", "--connect", endpoint, environment={"XDG_STATE_HOME": str(tmp_path)})
    process.wait_for_output("waiting for a Zenoh router")
    start("services.router", "--listen", endpoint).wait_for_output("listening")
    around = Surroundings(endpoint)
    try:
        eventually(around.ready, 30.0, "ready")
    finally:
        around.close()


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
    process = start("services.task", "--set", assignment)
    assert process.wait() == 2
    (line,) = process.output.splitlines()
    for part in BAD[assignment]:
        assert part in line, json.dumps(line)
