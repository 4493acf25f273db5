"""A table of figures, for the page, the terminal and `claims.json`."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Table:
    """What is shown as it is: every cell in words.

    Attributes:
        title: what it shows.
        head: names of its columns.
        rows: as many cells each; the first one names the row.
    """

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
