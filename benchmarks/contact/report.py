"""The contact benchmark's table, files and claims."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.contact.measure import OVER, Row
from benchmarks.contact.simulate import Result


@dataclass(frozen=True)
class Claim:
    """Something that has to hold."""

    text: str
    measured: str
    passed: bool


@dataclass(frozen=True)
class Column:
    """A figure about the results of one law in one set.

    Attributes:
        title: in the table.
        of: the figure.
        text: how the table shows it, as a format.
    """

    title: str
    of: Callable[[list[Result]], float]
    text: str


def _peak(quantile: float) -> Callable[[list[Result]], float]:
    return lambda results: float(np.quantile([one.peak for one in results], quantile))


COLUMNS = {
    "cases": Column("cases", len, "d"),
    "covered": Column("covered", lambda results: sum(one.covered for one in results), "d"),
    "p50": Column("p50", _peak(0.5), ".3f"),
    "p95": Column("p95", _peak(0.95), ".3f"),
    "highest": Column("max", _peak(1.0), ".4f"),
    "over": Column("over", lambda results: float(np.mean([one.peak > OVER for one in results])), ".1%"),
    "sustained": Column("swinging", lambda results: float(np.mean([one.sustained for one in results])), ".1%"),
    "travelled": Column("path m", lambda results: float(np.median([one.travelled for one in results])), ".3f"),
    "missing": Column("missing m", lambda results: float(np.median([one.missing for one in results])), ".3f"),
}
"""By their names in `summary.json`; peaks in limits, lengths in metres."""


def summarise(rows: list[Row]) -> list[dict[str, Any]]:
    """One map per set and law, sets in the order of the rows."""
    groups = list(dict.fromkeys(row.job.group for row in rows))
    laws = list(dict.fromkeys(row.law for row in rows))
    return [
        {"group": group, "law": law} | {name: column.of(chosen) for name, column in COLUMNS.items()}
        for group in groups
        for law in laws
        if (chosen := [row.result for row in rows if row.job.group == group and row.law == law])
    ]


def print_summaries(console: Console, summaries: list[dict[str, Any]]) -> None:
    table = Table("set", "law", title="contact: peak of abs(wrench)/limit, laws side by side on the same cases")
    for column in COLUMNS.values():
        table.add_column(column.title, justify="right")
    previous = ""
    for one in summaries:
        group, law = one["group"], one["law"]
        if group != previous:
            table.add_section()
        figures = (format(one[name], column.text) for name, column in COLUMNS.items())
        style = "" if law.startswith("certified") else "dim"
        table.add_row(group if group != previous else "", law, *figures, style=style)
        previous = group
    console.print(table)


def print_claims(console: Console, claims: list[Claim]) -> None:
    table = Table("", "claim", "measured", title="claims")
    for claim in claims:
        table.add_row("[green]pass" if claim.passed else "[bold red]FAIL", claim.text, claim.measured)
    console.print(table)


def write_csv(path: Path, records: Sequence[Mapping[str, object]]) -> None:
    """Writes records of equal names, one line each, making the folder."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, list(records[0]) if records else [])
        writer.writeheader()
        writer.writerows(records)


def write(
    folder: Path, rows: list[Row], summaries: list[dict[str, Any]], claims: list[Claim], facts: dict[str, object]
) -> None:
    """Writes `cases.csv`, one line per law and case, and `summary.json` into ``folder``."""
    write_csv(folder / "cases.csv", [row.record() for row in rows])
    document = {**facts, "claims": [asdict(c) for c in claims], "summaries": summaries}
    (folder / "summary.json").write_text(json.dumps(document, indent=1) + "\n")
