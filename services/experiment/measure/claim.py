"""What an experiment claims and whether its recordings bear it out."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Claim:
    """One line of the table. `run` is the run's name, or two names for a comparison; `short` says `text` in a row."""

    run: str
    short: str
    text: str
    figure: str
    limit: str
    passed: bool
