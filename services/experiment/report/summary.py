"""What a report says in short, and what all reports share; each experiment writes its own."""

from __future__ import annotations

import dataclasses
import json
import platform
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

from services.experiment.measure.claim import Claim
from services.experiment.play.recording import RECORDING, Recording
from services.experiment.report.table import Table
from services.experiment.run import Run

Found = TypeVar("Found")


@dataclass(frozen=True)
class Report:
    """What was written and what it says.

    Attributes:
        index: the page.
        claims: all of them, in order.
        problems: what may have disturbed a run, a line each.
        unfinished: runs that are not judged, and why.
    """

    index: Path
    claims: list[Claim]
    problems: list[str]
    unfinished: list[str]


@dataclass(frozen=True)
class Measured(Generic[Found]):
    """The runs that were played to the end, by their names, and those that were not.

    Attributes:
        runs: what was played.
        recordings: of it.
        figures: taken from them.
        unfinished: a line for each other run, which is not judged.
    """

    runs: dict[str, Run]
    recordings: dict[str, Recording]
    figures: dict[str, Found]
    unfinished: list[str]


def measure_all(
    folder: Path, known: Iterable[Run], names: str, measure: Callable[[Recording], Found]
) -> Measured[Found]:
    """The figures of all runs that were recorded under `folder`.

    Args:
        folder: with one subfolder per run.
        known: every run that there may be.
        names: of them, for people.
        measure: takes the figures of one.

    Raises:
        FileNotFoundError: there is no recording.
        ValueError: no run was played to the end.
    """
    runs = {run.name: run for run in known if (folder / run.name / RECORDING).exists()}
    if not runs:
        raise FileNotFoundError(f"{folder}: no recording of any run {names}")
    recordings = {name: Recording.load(folder / name / RECORDING) for name in runs}
    figures, unfinished = {}, []
    for name, recording in recordings.items():
        try:
            figures[name] = measure(recording)
        except (KeyError, ValueError) as problem:
            unfinished.append(f"{name} is not judged: {problem.args[0]}")
    if not figures:
        raise ValueError("; ".join(unfinished))
    return Measured(
        {name: runs[name] for name in figures},
        {name: recordings[name] for name in figures},
        figures,
        unfinished,
    )


def conclude(
    folder: Path,
    text: str,
    claims: list[Claim],
    measured: Mapping[str, Any],
    problems: list[str],
    unfinished: list[str],
    tables: Sequence[Table] = (),
) -> Report:
    """Writes the page and `claims.json`; `measured` are the figures of each run, dataclasses.

    The first of the tables is what the terminal shows too.
    """
    index = folder / "index.html"
    index.write_text(text, encoding="utf-8")
    summary = {
        "claims": [dataclasses.asdict(claim) for claim in claims],
        "tables": [dataclasses.asdict(table) for table in tables],
        "measures": {name: dataclasses.asdict(found) for name, found in measured.items()},
        "problems": problems,
    }
    (folder / "claims.json").write_text(json.dumps(summary, indent=2), encoding="utf-8")
    return Report(index, claims, problems, unfinished)


def origin(recordings: Mapping[str, Recording]) -> dict[str, str]:
    """Where and when recordings were made, for the page."""
    first = next(iter(recordings.values()))
    version = ".".join(str(part) for part in sys.version_info[:3])
    return {
        "when": str(first.meta.get("date", "")),
        "machine": f"{platform.machine()}, {platform.system()}, Python {version}",
        "bus": str(first.meta.get("bus", "")),
    }
