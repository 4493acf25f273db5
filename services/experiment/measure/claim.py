"""What an experiment finds: claims that its recordings bear out or do not, and tables of figures."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

Row = tuple[str, str, str, str, bool]
"""What a claim says beside the run's name: short, text, figure, limit, passed."""


@dataclass(frozen=True)
class Claim:
    """One line of the claims.

    Attributes:
        run: name of the run, or two names for a comparison.
        short: the claim in a few words, for the terminal.
        text: the claim.
        figure: what was found.
        limit: what it is held against.
        passed: whether it is borne out.
    """

    run: str
    short: str
    text: str
    figure: str
    limit: str
    passed: bool

    @classmethod
    def of(cls, run: str, rows: Iterable[Row]) -> list[Claim]:
        """The claims about a run."""
        return [cls(run, *row) for row in rows]


@dataclass(frozen=True)
class Table:
    """Figures that are shown as they are: every cell in words.

    Attributes:
        title: what it shows.
        head: names of its columns.
        rows: as many cells each; the first one names the row.
    """

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
