"""The experiments that there are, and what is made of recordings in a folder: by a command line, or by `tandem run`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from services.experiment.carry.carry import CARRY
from services.experiment.load.load import LOAD
from services.experiment.play.recording import RECORDING, Recording, told
from services.experiment.spec import Experiment

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

    Raises:
        FileNotFoundError: there is no recording.
        ValueError: it is damaged.
        KeyError, Misconfigured: it lacks what the film shows.
    """
    from services.sim.film.film import FILM, render

    path = folder / RECORDING
    render(_played(path).film_data(Recording.load(path)), folder)
    return folder / FILM


def _played(path: Path) -> Experiment:
    """The experiment that a recording is of."""
    name = told(path).get("experiment")
    if name not in EXPERIMENTS:
        raise ValueError(f"{path}: of experiment {name!r}, known are {', '.join(EXPERIMENTS)}")
    return EXPERIMENTS[name]
