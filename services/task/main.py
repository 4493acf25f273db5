"""The carrying task as a process."""

from __future__ import annotations

from collections.abc import Sequence

from services.task.parameters import TaskParameters
from services.task.task import Task
from shared.clock import SteadyClock, seconds
from shared.process import run
from shared.storage import default_folder


def main(arguments: Sequence[str] | None = None) -> int:
    """Run until SIGTERM; returns the exit status."""

    def make(parameters: TaskParameters) -> Task:
        clock = SteadyClock()
        return Task(parameters, lambda: seconds(clock.now_ns()), default_folder())

    return run(make, TaskParameters, "task", None if arguments is None else list(arguments))
