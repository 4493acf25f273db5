"""What an experiment is made of: its runs and their course, and the account that is given of the recordings."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from services.experiment.measure.claim import Claim, Table
from services.experiment.play.course import Ask, Course, Run
from services.experiment.play.player import Answered, OnHeard, Player
from services.experiment.play.recording import Recording
from services.viewer.take import Part
from shared.clock import Clock
from shared.messages import ControlTarget
from shared.wire.bus import Bus

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Found = TypeVar("Found")


@dataclass(frozen=True)
class Drawn:
    """A figure, the name of its file without the ending, its caption, and the run that it is of; of all if empty."""

    name: str
    figure: Figure
    caption: str
    run: str = ""


@dataclass(frozen=True)
class Account(Generic[Found]):
    """What is told of the recordings of an experiment; `Found` are the figures taken of one run, a dataclass.

    Attributes:
        title: of the page.
        lead: what takes place, in two sentences.
        facts: about all runs, by their names.
        films: what is shown of a run if it is there: file in its folder -> caption.
        measure: takes the figures of a run; KeyError or ValueError says what its recording lacks.
        sentence: what became of a run, in one sentence that goes on after its title.
        judge: claims about the runs and their figures, both by the runs' names.
        notes: what a reader has to know to judge the claims.
        draw: figures, made when each is asked for.
        tables: the first of them is what the terminal shows, too.
    """

    title: str
    lead: str
    facts: Mapping[str, str]
    films: Mapping[str, str]
    measure: Callable[[Recording], Found]
    sentence: Callable[[Run, Found], str]
    judge: Callable[[Mapping[str, Run], Mapping[str, Found]], list[Claim]]
    notes: Callable[[Mapping[str, Found]], list[str]]
    draw: Callable[[Mapping[str, Run], Mapping[str, Recording], Mapping[str, Found]], Iterable[Drawn]]
    tables: Callable[[Mapping[str, Found]], list[Table]] = lambda measured: []


@dataclass(frozen=True)
class Experiment:
    """One experiment.

    Attributes:
        name: of it.
        runs: that are played unless others are asked for.
        known: every run that there is, those first.
        choice: how to name one.
        duration: of a run [s], about, for the progress.
        filmed: the name of the run that the film shows, if it is among those played.
        beside: the name of the run that the film shows on the left of that one, if it is among those played.
        course: of a run.
        parts: what happens in a recording; KeyError or ValueError says what it lacks.
        account: what is told of the recordings.
        target: to hold during a run; None if the stack's own task says what to hold.
        meta: what is to be said of every run besides its configuration.
    """

    name: str
    runs: Sequence[Run]
    known: Sequence[Run]
    choice: str
    duration: float
    filmed: str
    beside: str
    course: Callable[[Run], Course]
    parts: Callable[[Recording], Sequence[Part]]
    account: Account[Any]
    target: ControlTarget | None = None
    meta: dict[str, Any] = field(default_factory=dict)

    def run_named(self, name: str) -> Run:
        """The run of a name; ValueError says how to name one."""
        for run in self.known:
            if run.name == name:
                return run
        raise ValueError(f"there is no run {name!r}; choose {self.choice}")

    def chosen(self, names: Sequence[str]) -> Sequence[Run]:
        """The runs of these names, those that are usual if there are none; ValueError says how to name one."""
        return [self.run_named(name) for name in names] or self.runs

    def shown(self, runs: Sequence[Run]) -> list[Run]:
        """The run of these that a film is made of, and the one beside it, if there is one."""
        named = {run.name: run for run in runs}
        if self.filmed not in named:
            return [runs[0]]
        return [named[name] for name in (self.filmed, self.beside) if name in named]

    def player(self, run: Run, bus: Bus, clock: Clock, ask: Callable[[Ask, Answered], None], record: OnHeard) -> Player:
        """The service that plays a run."""
        return Player(self.course(run), self.target, {"experiment": self.name, **self.meta}, bus, clock, ask, record)
