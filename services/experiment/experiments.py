"""The experiments that there are, and what is made of recordings in a folder: by a command line, or by `tandem run`."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from services.experiment.carry.carry import CARRY
from services.experiment.load.load import LOAD
from services.experiment.play.recording import RECORDING, Recording, told
from services.experiment.spec import Experiment
from services.viewer.take import Take
from shared.loop.config import Misconfigured

if TYPE_CHECKING:
    from services.experiment.report.report import Report

EXPERIMENTS = {experiment.name: experiment for experiment in (LOAD, CARRY)}


def report(folder: Path, commands: Sequence[str] = ()) -> Report:
    """Judges the runs recorded under a folder, one subfolder each, and writes their page.

    Args:
        folder: where the runs lie and the page goes.
        commands: how they were run, for the page.

    Raises:
        FileNotFoundError: there is no recording.
        ValueError: a recording is damaged, or no run was played to the end.
    """
    # What draws takes its time to be imported.
    from services.experiment.report.report import recorded, write

    first = next(iter(sorted(folder.glob(f"*/{RECORDING}"))), None)
    if first is None:
        raise FileNotFoundError(f"{folder}: no recording of any run")
    experiment = _played(first)
    return write(experiment, recorded(experiment, folder), folder, commands)


def film(folder: Path) -> Path:
    """Renders the run recorded in a folder, beside its recording; returns the film's path.

    The paper's law is on its left if this is the run that is filmed, and the other one was recorded beside it.

    Raises:
        FileNotFoundError: there is no recording.
        ValueError: it is damaged.
        KeyError, Misconfigured: it lacks what the film shows, or this machine does.
    """
    try:
        from services.viewer.film import FILM, render
    except ImportError as problem:
        raise Misconfigured(f"{problem.name} is not installed: pip install '.[experiment]' in its checkout") from None

    experiment = _played(folder / RECORDING)
    takes = [_take(experiment, folder)]
    beside = folder.parent / experiment.beside
    if folder.name == experiment.filmed and (beside / RECORDING).exists():
        # One that was not played to its end is not shown.
        with suppress(KeyError, ValueError):
            takes.insert(0, _take(experiment, beside))
    render(takes, folder)
    return folder / FILM


def _take(experiment: Experiment, folder: Path) -> Take:
    recording = Recording.load(folder / RECORDING)
    run = experiment.run_named(recording.meta["name"])
    return Take(folder / RECORDING, run.title, recording.zero, experiment.parts(recording))


def _played(path: Path) -> Experiment:
    """The experiment that a recording is of."""
    name = told(path).get("experiment")
    if name not in EXPERIMENTS:
        raise ValueError(f"{path}: of no run of an experiment ({', '.join(EXPERIMENTS)})")
    return EXPERIMENTS[name]
