"""What a report says in short; each experiment writes its own."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from services.experiment.claim import Claim


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
