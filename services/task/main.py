"""The carrying task as a process."""

from __future__ import annotations

from collections.abc import Sequence

from services.task.parameters import TaskParameters
from services.task.task import Task
from shared.clock import SteadyClock, seconds
from shared.loop.config import settings
from shared.loop.files import default_folder
from shared.loop.process import run

NAME = "task"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run until SIGTERM; returns the exit status."""

    def make(parameters: TaskParameters) -> Task:
        clock = SteadyClock()
        # A folder for each robot: what one of them holds means nothing to another.
        folder = default_folder() / settings(NAME, TaskParameters, arguments).robot
        return Task(parameters, lambda: seconds(clock.now_ns()), folder)

    return run(make, TaskParameters, NAME, arguments)
