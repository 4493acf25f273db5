"""The whole carry in one process under a simulated clock, for tests that disturb it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.carry.judge import Verdict, judge
from benchmarks.carry.witness import Witness
from benchmarks.experiment_stack import Together
from services.experiment.carry import carry_protocol as protocol
from shared import topics
from shared.messages import TaskStatus

LONGEST = 120.0
"""Simulated time [s] within which anything that is waited for has to have come."""


class CarryRig:
    """All services, a panel and a person; tared, with the task started.

    Attributes:
        services: that run.
        client: to speak with them.
        states: of the task, each with the time [s] at which it began and the reason.

    Args:
        folder: where the services keep what outlives them.
        base: of the protocol.
    """

    def __init__(self, folder: Path, base: str = "omni") -> None:
        self.services = Together(protocol.run("certified", base), folder)
        self.stack, self.client = self.services.stack, self.services.stack.client
        self.witness = Witness(self.services.simulator, protocol.PANEL_SIZE[2], warning="")
        self.stack.add(self.witness)
        self.states: list[tuple[float, str, str]] = []
        self._task = self.client.watch(topics.TASK_STATUS, lambda received: self._note(received.message))
        self.stack.run(1.5)
        self.client.ask(topics.WRENCH_TARE, {"duration": 1.0})
        self.sim("hand", script="carry")
        self.tell("start")

    @property
    def task(self) -> TaskStatus:
        assert self._task.latest is not None
        return self._task.latest.message

    @property
    def doing(self) -> str:
        """What the person does."""
        scene = self.services.simulator.world.panel_scene
        assert scene is not None
        return scene.person.doing

    def sim(self, command: str, **request: Any) -> None:
        self.client.ask(topics.SIM_COMMAND, {"command": command, **request})

    def tell(self, command: str) -> None:
        """Say something to the task."""
        self.client.ask(topics.TASK_COMMAND, {"command": command})

    def reaches(self, *states: str) -> None:
        """Go on until the task is in one of these states."""
        self.stack.run(LONGEST, done=lambda: self.task.state in states)
        assert self.task.state in states, f"still {self.task.state}: {self.task.reason}"

    def says(self, words: str) -> None:
        """Go on until the task says something with these words."""
        self.stack.run(LONGEST, done=lambda: words in self.task.reason)
        assert words in self.task.reason, f"{self.task.state}: {self.task.reason}"

    def person(self, doing: str) -> None:
        """Go on until the person is about something."""
        self.stack.run(LONGEST, done=lambda: self.doing == doing)
        assert self.doing == doing, f"the person is still about {self.doing}, the task {self.task.reason}"

    def carry_up_to(self, doing: str) -> None:
        """Go on until the panel is carried and the person is about something."""
        self.reaches("carrying")
        self.sim("cover_marker")
        self.person(doing)

    def movement(self, duration: float) -> tuple[float, float]:
        """How far the tool moves in base, and the base [m], within a time [s]."""
        world = self.services.simulator.world
        tool, base = world.arm.tool_position.copy(), np.array((world.base.x, world.base.y))
        self.stack.run(duration)
        moved = float(np.linalg.norm(world.arm.tool_position - tool))
        return moved, float(np.hypot(*(np.array((world.base.x, world.base.y)) - base)))

    @property
    def verdict(self) -> Verdict:
        """What became of the panel up to now."""
        limits = np.array(protocol.FORCE_LIMIT + protocol.TORQUE_LIMIT)
        return judge(self.witness.seen(), limits, self.task.state, self.task.reason, told=())

    def _note(self, status: TaskStatus) -> None:
        if not self.states or self.states[-1][1] != status.state:
            self.states.append((self.stack.now, status.state, status.reason))
