"""One run of an experiment: a stack with its own robot name, and the experiment that plays on it."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Any

from services.cli.stack.children import STOP_PATIENCE, Child, Children
from services.cli.stack.plan import Plan
from services.cli.stack.processes import Stack


class Lane:
    """Plays one run. Poll `finished`, then `close`."""

    def __init__(
        self, experiment: str, run: dict[str, Any], plan: Plan, folder: Path, children: Children
    ) -> None:
        """Starts the stack's processes and the experiment; their output goes to files in `folder`."""
        self.title: str = run["title"]
        self.phase = "starting"
        self.reason = ""
        self.elapsed: float | None = None
        self._name: str = run["name"]
        self._stack = Stack(plan, children, logs=folder, with_router=False)
        arguments = [
            "play",
            experiment,
            "--robot",
            plan.robot,
            "--connect",
            plan.endpoint,
            "--run",
            self._name,
        ]
        arguments += ["--out", str(folder), "--json"]
        self._experiment = children.start(
            Child("experiment", arguments, folder / "experiment.log", self._hear)
        )

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
        """Whether the experiment has ended, or cannot be played because a process refused its configuration."""
        refused = any(child.status == 2 for child in self._stack.ended().values())
        return refused or self._experiment.status is not None

    def close(self) -> str:
        """Ends the processes; returns why the run did not complete, empty if it did."""
        trouble, status = self.trouble(), self._experiment.status
        processes = [self._experiment, *self._stack.processes.values()]
        for child in processes:
            child.terminate()
        deadline = time.monotonic() + STOP_PATIENCE
        for child in processes:
            child.finish(deadline)
        self._stack.plan.forget()
        if status == 0:
            return ""
        reason = trouble if status is None else self._experiment.last_line
        return f"{self._name}: {reason or f'the experiment {self._experiment.how_it_ended()}'}"
