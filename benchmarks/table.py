"""One row per claim: what was measured, what was aimed at, and the command that measures it again."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass

from rich.console import Console
from rich.table import Table
from rich.text import Text


@dataclass(frozen=True)
class Row:
    """One line of the table of ``make bench``.

    Attributes:
        claim: what is measured, in words.
        measured: the figure with its unit, or why there is none.
        target: what it is held against, empty if it is shown for comparison only.
        met: whether the target was reached; None without a target or without a measurement.
        command: what to type to measure it again.
    """

    claim: str
    measured: str
    target: str
    met: bool | None
    command: str


def at_most(claim: str, value: float, limit: float, unit: str, command: str, note: str = "") -> Row:
    """A claim that is met if ``value`` is at most ``limit``, both in ``unit`` ("" for a ratio)."""
    return Row(claim, _figure(value, unit, note), f"≤ {_figure(limit, unit)}", value <= limit, command)


def at_least(claim: str, value: float, limit: float, unit: str, command: str, note: str = "") -> Row:
    """A claim that is met if ``value`` is at least ``limit``, both in ``unit`` ("" for a ratio)."""
    return Row(claim, _figure(value, unit, note), f"≥ {_figure(limit, unit)}", value >= limit, command)


def shown(claim: str, value: float, unit: str, command: str, note: str = "") -> Row:
    """A figure without a target, for comparison."""
    return Row(claim, _figure(value, unit, note), "", None, command)


def skipped(claim: str, reason: str, command: str) -> Row:
    """A claim that could not be measured here, by name and with the reason."""
    return Row(claim, f"skipped: {reason}", "", None, command)


def _figure(value: float, unit: str, note: str = "") -> str:
    text = f"{value:.3g}" if abs(value) < 1000 else f"{value:,.0f}"
    return f"{text}{' ' if unit else ' times'}{unit}{f' ({note})' if note else ''}"


def show(rows: Sequence[Row]) -> None:
    """Print the rows, in full width where the output is no terminal, and how busy the machine was."""
    busy = f"load average {os.getloadavg()[1]:.1f} over the last five minutes on {os.cpu_count()} cores"
    table = Table(
        title="tandem: what was claimed and what was measured",
        title_justify="left",
        caption=busy,
        caption_justify="left",
    )
    for column in ("claim", "measured", "target", "met", "command"):
        table.add_column(column, overflow="fold")
    for row in rows:
        met = Text() if row.met is None else Text("yes", "green") if row.met else Text("NO", "red")
        table.add_row(Text(row.claim), Text(row.measured), Text(row.target), met, Text(row.command))
    Console(width=None if sys.stdout.isatty() else 180).print(table)


def missed(rows: Sequence[Row]) -> list[Row]:
    """The rows whose target was not reached."""
    return [row for row in rows if row.met is False]
