"""The contact benchmark's table, files and claims."""

from __future__ import annotations

import csv
import json
from dataclasses import asdict, dataclass
from pathlib import Path

from rich.console import Console
from rich.table import Table

from benchmarks.contact.measure import Row, Summary


@dataclass(frozen=True)
class Claim:
    """Something that has to hold."""

    text: str
    measured: str
    passed: bool


def print_summaries(console: Console, summaries: list[Summary]) -> None:
    table = Table(title="contact: peak of abs(wrench)/limit, laws side by side on the same cases")
    for name in ("set", "law"):
        table.add_column(name)
    for name in ("cases", "covered", "p50", "p95", "max", "over", "swinging", "path mm", "missing mm"):
        table.add_column(name, justify="right")
    previous = ""
    for summary in summaries:
        if previous and summary.group != previous:
            table.add_section()
        table.add_row(
            summary.group if summary.group != previous else "",
            summary.law,
            str(summary.cases),
            str(summary.covered),
            f"{summary.p50:.3f}",
            f"{summary.p95:.3f}",
            f"{summary.highest:.4f}",
            f"{summary.over:.1%}",
            f"{summary.sustained:.1%}",
            f"{summary.travelled * 1e3:.0f}",
            f"{summary.missing * 1e3:.0f}",
            style="" if summary.law.startswith("certified") else "dim",
        )
        previous = summary.group
    console.print(table)


def print_claims(console: Console, claims: list[Claim]) -> None:
    table = Table(title="claims")
    table.add_column("")
    table.add_column("claim")
    table.add_column("measured")
    for claim in claims:
        table.add_row("[green]pass" if claim.passed else "[bold red]FAIL", claim.text, claim.measured)
    console.print(table)


def write(
    folder: Path, rows: list[Row], summaries: list[Summary], claims: list[Claim], facts: dict[str, object]
) -> None:
    """Writes `cases.csv`, one line per law and case, and `summary.json` into ``folder``."""
    folder.mkdir(parents=True, exist_ok=True)
    records = [row.record() for row in rows]
    if records:
        with (folder / "cases.csv").open("w", newline="") as file:
            writer = csv.DictWriter(file, list(records[0]))
            writer.writeheader()
            writer.writerows(records)
    document = {**facts, "claims": [asdict(c) for c in claims], "summaries": [asdict(s) for s in summaries]}
    (folder / "summary.json").write_text(json.dumps(document, indent=1) + "\n")
