"""One run of an experiment: a stack with its own robot name, and the process that plays on it."""

from __future__ import annotations

import json
import time
from pathlib import Path

from services.cli.stack.children import STOP_PATIENCE, Child, Children
from services.cli.stack.plan import Plan
from services.cli.stack.processes import StackProcesses
from services.experiment.play.course import Run
from shared.processes import EXPERIMENT


class Lane:
    """Plays one run. Poll `finished`, then `close`.

    Attributes:
        title: of the run.
        phase, reason: what happens, and why, in the player's words.
        elapsed: time on the protocol's clock [s]; None before it starts.
    """

    def __init__(self, experiment: str, run: Run, plan: Plan, folder: Path, children: Children) -> None:
        """Starts the stack's processes and the player; their output goes to files in `folder`."""
        self.title = run.title
        self.phase = "starting"
        self.reason = ""
        self.elapsed: float | None = None
        self._name = run.name
        self._stack = StackProcesses(plan, children, logs=folder, with_router=False)
        arguments = ["play", experiment, "--robot", plan.robot, "--connect", plan.endpoint]
        arguments += ["--run", run.name, "--out", str(folder), "--json"]
        log = folder / f"{EXPERIMENT.name}.log"
        self._player = children.start(Child(EXPERIMENT.name, arguments, log, self._hear))

    def _hear(self, line: str) -> None:
        try:
            said = json.loads(line)
        except json.JSONDecodeError:
            return
        if isinstance(said, dict):
            self.phase = said.get("event") or said.get("phase", "")
            self.reason = said.get("reason", "")
            self.elapsed = said.get("elapsed")

    def trouble(self) -> str:
        """Processes of the stack that have ended, in words; empty if all run."""
        return "; ".join(f"{name} {child.how_it_ended()}" for name, child in self._stack.ended().items())

    def finished(self) -> bool:
        """Whether the player has ended, or cannot play because a process refused its configuration."""
        refused = any(child.status == 2 for child in self._stack.ended().values())
        return refused or self._player.status is not None

    def close(self) -> str:
        """Ends the processes; returns why the run did not complete, empty if it did."""
        trouble, status = self.trouble(), self._player.status
        processes = [self._player, *self._stack.processes.values()]
        for child in processes:
            child.terminate()
        deadline = time.monotonic() + STOP_PATIENCE
        for child in processes:
            child.finish(deadline)
        self._stack.plan.forget()
        if status == 0:
            return ""
        reason = trouble if status is None else self._player.last_line
        return f"{self._name}: {reason or f'the experiment {self._player.how_it_ended()}'}"
