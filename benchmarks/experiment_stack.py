"""An experiment with all services in one process under a simulated clock."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from services.base.base import Base
from services.base.parameters import BaseParameters
from services.controller.controller import Controller
from services.controller.parameters import ControllerParameters
from services.experiment.play.course import Ask, Run
from services.experiment.play.player import Answered
from services.experiment.play.process import Compose
from services.experiment.play.recording import END, RUN, Recording
from services.experiment.spec import Experiment
from services.sim.camera.head_camera import DirectRendering, Rendering
from services.sim.camera.view import Scenery
from services.sim.parameters import SimParameters
from services.sim.simulator import Simulator
from services.task.parameters import TaskParameters
from services.task.task import Task
from services.wrench.parameters import WrenchParameters
from services.wrench.wrench import Wrench
from shared.clock import seconds
from shared.loop.runner import Runner
from shared.loop.stack import Stack
from shared.service import Service
from shared.wire.codec import decode_map, encode_map
from shared.wire.log import Heard, write_log

_BUS = "in-process, simulated time"
LATENCY = 0.0005  # [s] of every message, about what the router takes
LONGEST = 240.0  # [s] of simulated time for one run, settling included


class Together:
    """All services of a run in one process.

    Attributes:
        stack: the services.
        simulator: the robot and what is around it.
        runners: what runs each service, by its name.

    Args:
        run: which services, with which settings.
        folder: where the services keep what outlives them.
        rendering: where the camera's pictures are rendered.
    """

    def __init__(self, run: Run, folder: Path, rendering: Callable[[Scenery], Rendering] = DirectRendering) -> None:
        self.stack = Stack(LATENCY)
        self.runners: dict[str, Runner] = {}
        settings = run.settings
        self._task = TaskParameters.of(settings.get("task", {}))
        self._folder = folder
        self._add_robot(settings.get("sim", {}), rendering)
        self._add(Wrench(WrenchParameters.of(settings.get("wrench", {})), folder))
        self._add(Controller(ControllerParameters.of(settings.get("controller", {}))))
        if "base" in run.further:
            self._add(Base(BaseParameters.of(settings.get("base", {}))))
        if "task" in run.further:
            self.start_task()

    def _add_robot(self, settings: Mapping[str, Any], rendering: Callable[[Scenery], Rendering]) -> None:
        self.simulator = Simulator(SimParameters.of(settings), rendering)
        self._add(self.simulator)

    def start_task(self) -> None:
        """Start the task, or another one in place of one that was killed."""
        clock = self.stack.scheduler.clock
        self._add(Task(self._task, lambda: seconds(clock.now_ns()), self._folder))

    def _add(self, service: Service) -> None:
        self.runners[service.wiring.name] = self.stack.add(service)


class Staged(Together):
    """A stack with a player on it.

    Attributes:
        player: of the run.
        heard: what it recorded.

    Args:
        compose: makes the player.
        run: that it plays.
        folder: where the services keep what outlives them.
        rendering: where the camera's pictures are rendered.
    """

    def __init__(
        self, compose: Compose, run: Run, folder: Path, rendering: Callable[[Scenery], Rendering] = DirectRendering
    ) -> None:
        super().__init__(run, folder, rendering)
        self.heard: list[Heard] = []
        self.player = compose(self.stack.bus, self.stack.scheduler.clock, self._ask, self._take)
        self.stack.add(self.player)

    def _take(self, key: str, arrival_ns: int, payload: bytes) -> None:
        self.heard.append(Heard(key, arrival_ns, bytes(payload)))

    def _ask(self, ask: Ask, answered: Answered) -> None:
        served = self.stack.bus.query_later(
            ask.query.key, encode_map(ask.request), lambda payload: answered(decode_map(payload))
        )
        if not served:
            answered({"ok": False, "error": f"nobody serves {ask.query.key}"})


def play_run(
    experiment: Experiment,
    run: Run,
    rendering: Callable[[Scenery], Rendering] = DirectRendering,
    path: Path | None = None,
    staged_by: type[Staged] = Staged,
) -> Recording:
    """Plays one run in simulated time; what was heard goes to a file, too, if one is named.

    Args:
        experiment: whose claims it is judged by.
        run: of it.
        rendering: where the camera's pictures are rendered.
        path: of the file.
        staged_by: builds the stack.

    Raises:
        services.experiment.play.course.Failed: the experiment could not be completed.
        TimeoutError: it did not end.
    """
    with tempfile.TemporaryDirectory() as folder:
        staged = staged_by(partial(experiment.player, run), run, Path(folder), rendering)
        staged.stack.run(LONGEST, done=lambda: staged.player.finished)
    if not staged.player.finished:
        raise TimeoutError(f"{run.name}: still {staged.player.course.phase} after {LONGEST:g} s of simulated time")
    if path is not None:
        write_log(path, {"bus": _BUS}, staged.heard, **{RUN: staged.player.about(), END: staged.player.end()})
    return Recording.of(staged.player.about(bus=_BUS), staged.heard, staged.player.end())
