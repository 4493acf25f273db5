"""The carry with the real processes over a real router, as a user starts and disturbs it.

What depends on how well the machine keeps time (forces, lags) is judged in simulated time, see test_carry.py.
"""

from __future__ import annotations

import json
import os
import signal
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from shared import topics
from shared.messages import BaseState, TaskStatus
from shared.sim_messages import SimWorld
from shared.wire.client import Client
from shared.wire.zenoh import ZenohBus
from tests.services.cli.command import pids, tandem
from tests.support.ports import free_endpoint
from tests.support.processes import Process
from tests.support.wait import eventually, throughout

pytestmark = [pytest.mark.processes, pytest.mark.slow, pytest.mark.timeout(400)]
PATIENCE = 90.0  # [s]
WHATEVER_THE_MACHINE = (
    "every state and phase in order",
    "asks for the stated limits",
    "never drops the panel",
    "keeps it level",
    "lets go when the ground carries it",
    "lets go when it stands upright",
    "it stays where it was put",
)
"""Claims that hold however late samples and commands come."""


class Watched:
    """A stack for the carry, and what it says."""

    def __init__(self, process: Process, endpoint: str, client: Client) -> None:
        self.process = process
        self.endpoint = endpoint
        self._task = client.watch(topics.TASK_STATUS)
        self._base = client.watch(topics.STATE_BASE)
        self._world = client.watch(topics.SIM_WORLD)
        self._gripper = client.watch(topics.STATE_GRIPPER)

    @property
    def task(self) -> TaskStatus | None:
        return self._task.latest.message if self._task.latest else None

    @property
    def run(self) -> int:
        """Which run of the task spoke last."""
        return self._task.latest.header.session if self._task.latest else 0

    @property
    def base(self) -> BaseState:
        return eventually(lambda: self._base.latest).message

    @property
    def world(self) -> SimWorld:
        return eventually(lambda: self._world.latest).message

    @property
    def holds(self) -> bool:
        return self._gripper.latest is not None and self._gripper.latest.message.holding

    def says(self, *words: str) -> bool:
        return self.process.running and self.task is not None and all(word in self.task.reason for word in words)

    def reaches(self, state: str) -> None:
        eventually(lambda: self.task is not None and self.task.state == state, PATIENCE, f"the task is {state}")

    def lead(self, start: np.ndarray, forwards: float) -> None:
        """Guide the hands to 15 cm above a place (3,) [m] and that far [m] forwards of it."""
        self.tell("hand", *(f"{number:.3f}" for number in start + np.array((forwards, 0.0, 0.15))))

    def tell(self, *arguments: str) -> None:
        done = tandem(*arguments, "--connect", self.endpoint)
        assert done.returncode == 0, done.stderr


@pytest.fixture
def stack(tmp_path: Path) -> Iterator[Watched]:
    endpoint = free_endpoint()
    arguments, own = ["up", "--carry", "--no-view", "--connect", endpoint], {"XDG_STATE_HOME": str(tmp_path)}
    with Process("services.cli", arguments, tmp_path / "up", own) as process:
        eventually(lambda: not process.running or "task: ok" in process.output, PATIENCE, "the stack is up")
        assert process.running, process.output
        bus = ZenohBus(connect=endpoint)
        try:
            watched = Watched(process, endpoint, Client(bus))
            eventually(lambda: watched.says("ready"), PATIENCE, "the task is ready")
            eventually(lambda: tandem("tare", "--connect", endpoint).returncode == 0, PATIENCE, "tared")
            yield watched
        finally:
            bus.close()


def test_it_is_guided_by_hand_and_a_killed_task_goes_on_carrying(stack: Watched, tmp_path: Path) -> None:
    stack.tell("task", "start")
    stack.reaches("carrying")
    far = stack.world.panel.position + np.array((0.57, 0.0, 0.0))
    stack.lead(far, 0.0)
    eventually(lambda: stack.says("carrying; to be set down"), PATIENCE, "the panel is lifted")

    stack.lead(far, 0.4)
    eventually(lambda: stack.base.position[0] > 0.25, PATIENCE, "the base follows the hand")

    killed = stack.run
    os.kill(pids(stack.endpoint)["task"], signal.SIGKILL)
    eventually(lambda: "task: lost" in stack.process.output, PATIENCE, "the loss is shown")
    throughout(lambda: stack.holds, 1.0, "the gripper holds the panel without the task")
    arguments = ["start", "task", "--connect", stack.endpoint]
    with Process("services.cli", arguments, tmp_path / "task", {"XDG_STATE_HOME": str(tmp_path)}):
        # Not the last word of the one that was killed: led on before another is there, it would hold, as it should.
        eventually(
            lambda: stack.run != killed and stack.says("carrying; to be set down"),
            PATIENCE,
            lambda: f"the task carries on: {stack.task}",
        )
        stack.lead(far, 0.1)
        eventually(lambda: stack.base.position[0] < 0.15, PATIENCE, "the base follows the hand back")
        assert stack.holds


def test_a_covered_marker_makes_it_wait_and_say_why(stack: Watched) -> None:
    stack.tell("cover")
    stack.tell("task", "start")
    stack.reaches("searching")
    eventually(lambda: stack.says("no marker in sight: is it covered"), PATIENCE, "it says why it waits")
    assert stack.task is not None and stack.task.state == "searching"


def test_the_whole_carry_with_its_report(tmp_path: Path) -> None:
    out = tmp_path / "report"
    arguments = ["run", "carry", "--law", "certified", "--no-film", "--out", str(out)]
    with Process("services.cli", [*arguments, "--connect", free_endpoint()], tmp_path / "run") as process:
        eventually(lambda: not process.running, 300.0, "the run ends")
        said = process.output
    assert (out / "index.html").exists(), said
    claims = {claim["short"]: claim for claim in json.loads((out / "claims.json").read_text())["claims"]}
    for short in WHATEVER_THE_MACHINE:
        assert claims[short]["passed"], f"{claims[short]}\n{said}"
    assert "The runs side by side" in said
