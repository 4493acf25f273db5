"""Results of a check, one line each."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Row:
    """What was looked at, and what was found.

    Attributes:
        what: the key, or what was tried.
        good: whether it is as the contract says; None if it could not be tried, or need not be there.
        said: what was found; with what is allowed and what to do, if that is wrong.
    """

    what: str
    good: bool | None
    said: str

    def __str__(self) -> str:
        word = {True: "ok", False: "NO", None: "-"}[self.good]
        return f"{word:<4}{self.what}: {self.said}"


def judged(what: str, wrong: str, right: str) -> Row:
    """A row that is good if there is nothing wrong."""
    return Row(what, not wrong, wrong or right)
