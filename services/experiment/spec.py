"""What an experiment is made of: its runs, their course, and what becomes of the recordings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from services.experiment.play.course import Ask, Course
from services.experiment.play.player import Answered, Experiment
from services.experiment.play.recording import Recording
from services.experiment.report.summary import Report
from services.experiment.run import Run
from shared.clock import Clock
from shared.messages import ControlTarget
from shared.wire.bus import Bus


@dataclass(frozen=True)
class Play:
    """One experiment.

    Attributes:
        name: of it.
        runs: that are played unless others are asked for.
        run_named: the run of a name; ValueError lists what there is.
        duration: of a run [s], about, for the progress.
        filmed: the name of the run that the film shows, if it is among those played.
        course: of a run.
        report: judges the recordings under a folder and writes their page, given how they were made.
        film_data: writes what `services.sim.film.film` reads of a recording.
        target: to hold during a run; None if the stack's own task says what to hold.
        meta: what is to be said of every run besides its configuration.
    """

    name: str
    runs: Sequence[Run]
    run_named: Callable[[str], Run]
    duration: float
    filmed: str
    course: Callable[[Run], Course]
    report: Callable[[Path, Sequence[str]], Report]
    film_data: Callable[[Recording, Path], None]
    target: ControlTarget | None = None
    meta: dict[str, Any] = field(default_factory=dict)

    def experiment(
        self, run: Run, bus: Bus, clock: Clock, ask: Callable[[Ask, Answered], None]
    ) -> Experiment:
        """The service that plays a run."""
        meta = {"experiment": self.name, **self.meta}
        return Experiment(self.course(run), self.target, meta, bus, clock, ask)
