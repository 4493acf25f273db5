"""Turns recordings into a folder: page, figures, CSV of every series, films, claims as JSON."""

from __future__ import annotations

import dataclasses
import json
import platform
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from services.experiment.measure.claim import Claim, Table
from services.experiment.measure.disturbance import disturbances
from services.experiment.play.recording import RECORDING, Recording
from services.experiment.report.drawing import save
from services.experiment.report.page import Page
from services.experiment.spec import Experiment


@dataclass(frozen=True)
class Report:
    """What was written and what it says.

    Attributes:
        index: the page.
        claims: all of them, in order.
        tables: of figures.
        problems: what may have disturbed a run, a line each.
        unfinished: runs that are not judged, and why; among the problems, too.
    """

    index: Path
    claims: list[Claim]
    tables: list[Table]
    problems: list[str]
    unfinished: list[str]

    @property
    def good(self) -> bool:
        """Whether every run was judged and every claim holds."""
        return not self.unfinished and all(claim.passed for claim in self.claims)


def recorded(experiment: Experiment, folder: Path) -> dict[str, Recording]:
    """Recordings of the runs of an experiment, which lie in subfolders of their names.

    Raises:
        FileNotFoundError: there is none.
        ValueError: one is damaged.
    """
    recordings = {
        run.name: Recording.load(folder / run.name / RECORDING)
        for run in experiment.known
        if (folder / run.name / RECORDING).exists()
    }
    if not recordings:
        raise FileNotFoundError(f"{folder}: no recording of any run: choose {experiment.choice}")
    return recordings


def write(
    experiment: Experiment, recordings: Mapping[str, Recording], folder: Path, commands: Sequence[str] = ()
) -> Report:
    """Builds the report of runs of an experiment.

    Args:
        experiment: that was played.
        recordings: of the runs, by name.
        folder: that the page goes to, beside what the runs have left in subfolders of their names.
        commands: how they were run, for the page.

    Raises:
        ValueError: no run was played to the end.
    """
    account = experiment.account
    measured, unfinished = {}, []
    for name, recording in recordings.items():
        try:
            measured[name] = account.measure(recording)
        except (KeyError, ValueError) as problem:
            unfinished.append(f"{name} is not judged: {problem.args[0]}")
    if not measured:
        raise ValueError("; ".join(unfinished))
    runs = {run.name: run for run in experiment.known if run.name in measured}
    recordings = {name: recordings[name] for name in measured}
    claims, tables = account.judge(runs, measured), account.tables(measured)
    problems = [*unfinished, *disturbances(measured)]

    figures = folder / "figures"
    figures.mkdir(exist_ok=True)
    page = Page(
        title=account.title,
        lead=account.lead,
        claims=claims,
        tables=tables,
        figures=[
            (save(drawn.figure, figures / drawn.name)[0], drawn.caption)
            for drawn in account.draw(runs, recordings, measured)
        ],
        films=[
            (folder / name / film, f"{run.title}: {caption}")
            for name, run in runs.items()
            for film, caption in account.films.items()
            if (folder / name / film).exists()
        ],
        facts={**_origin(recordings), **account.facts},
        files={name: [folder / name / RECORDING] for name in recordings},
        notes=[*problems, *account.notes(measured)],
        commands=commands,
        settings={name: recording.meta["settings"] for name, recording in recordings.items()},
    )
    index = folder / "index.html"
    index.write_text(page.html(folder), encoding="utf-8")
    summary = {
        "claims": [dataclasses.asdict(claim) for claim in claims],
        "tables": [dataclasses.asdict(table) for table in tables],
        "measures": {name: dataclasses.asdict(found) for name, found in measured.items()},
        "problems": problems,
    }
    (folder / "claims.json").write_text(json.dumps(summary, indent=2), encoding="utf-8")
    return Report(index, claims, tables, problems, unfinished)


def _origin(recordings: Mapping[str, Recording]) -> dict[str, Any]:
    """Where and when recordings were made."""
    meta = next(iter(recordings.values())).meta
    return {
        "when": meta.get("date", ""),
        "machine": f"{platform.machine()}, {platform.system()}, Python {platform.python_version()}",
        "bus": meta.get("bus", ""),
    }
