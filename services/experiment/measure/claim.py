"""What an experiment finds: claims that its recordings bear out or do not, and tables of figures."""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

Standing = Literal["pass", "fail", "not judged"]
Row = tuple[str, str, str, bool]
"""What was found of a claim: short, figure, limit, passed."""


@dataclass(frozen=True)
class Claim:
    """One line of the claims.

    Attributes:
        run: name of the run, or two names, with a comma between, for a comparison.
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
    def of(cls, run: str, rows: Iterable[Row], texts: Mapping[str, str]) -> list[Claim]:
        """The claims about a run; `texts` says each short one at length."""
        return [cls(run, short, texts[short], figure, limit, passed) for short, figure, limit, passed in rows]

    @property
    def runs(self) -> tuple[str, ...]:
        """Names of the runs that it is about."""
        return tuple(self.run.split(", "))

    def standing(self, busy: Container[str]) -> Standing:
        """Whether it is borne out, given the runs for which the machine was too busy.

        What fails in such a run may be the machine's doing, and so may either outcome of a comparison with it. What
        holds in it counts: it held under worse conditions than were promised.
        """
        if any(run in busy for run in self.runs) and (not self.passed or len(self.runs) > 1):
            return "not judged"
        return "pass" if self.passed else "fail"


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
