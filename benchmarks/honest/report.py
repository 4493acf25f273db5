"""The table of all draws, what was false, and the targets."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from rich.console import Console
from rich.table import Table

from benchmarks.honest.verdict import Verdict
from benchmarks.table import Row, at_least, at_most

MOST_FALSE, LEAST_ACCEPTED = 0.0, 95.0  # draws, [%] of the sound ones
_COLUMNS = ("draws", "sound", "accepted", "unsound", "refused", "within its bound", "FALSE", "outside")
_SHOWN, _LONGEST = 3, 120  # refusals per kind, characters of each


def counts(verdicts: Sequence[Verdict]) -> tuple[int, ...]:
    """The columns of the table; what is outside is counted besides, whether it was refused later or not."""
    sound = [one for one in verdicts if one.sound]
    unsound = [one for one in verdicts if not one.sound]
    return (
        len(verdicts),
        len(sound),
        sum(_accepted(one) for one in sound),
        len(unsound),
        sum(bool(one.refused) and not one.false for one in unsound),
        sum(not (one.refused or one.false or one.outside) for one in unsound),
        sum(bool(one.false) for one in verdicts),
        sum(bool(one.outside) and not one.false for one in verdicts),
    )


def _accepted(verdict: Verdict) -> bool:
    return not verdict.refused and not verdict.false


def print_table(console: Console, verdicts: Sequence[Verdict]) -> None:
    """One line per kind, and the sum."""
    table = Table("kind", title="honest: what was stated of sensors and cameras", title_justify="left")
    for column in _COLUMNS:
        table.add_column(column, justify="right")
    for kind in dict.fromkeys(verdict.kind for verdict in verdicts):
        table.add_row(kind, *_figures(counts([one for one in verdicts if one.kind == kind])))
    table.add_section()
    table.add_row("all", *_figures(counts(verdicts)))
    console.print(table)


def _figures(values: Sequence[int]) -> list[str]:
    return [str(value) if value else "" for value in values]


def print_cases(console: Console, verdicts: Sequence[Verdict]) -> None:
    """The words of the refusals by their number, each false one, and why the rest is outside of all declarations."""
    for sound in (True, False):
        for kind in dict.fromkeys(verdict.kind for verdict in verdicts):
            words = Counter(one.refused[:_LONGEST] for one in verdicts if one.kind == kind and one.sound is sound)
            words.pop("", None)
            for text, count in words.most_common(_SHOWN):
                label = "sound but refused" if sound else "refused"
                console.print(f"{label}, {kind}, {count}: {text}", markup=False, highlight=False)
    for one in verdicts:
        if one.false:
            console.print(f"FALSE {one.kind}:{one.seed}: {one.false}", markup=False, highlight=False)
    reasons = Counter((one.kind, one.outside.partition(": ")[2]) for one in verdicts if one.outside and not one.false)
    for (kind, reason), count in sorted(reasons.items()):
        console.print(f"outside, {kind}, {count}: {reason}", markup=False, highlight=False)


def rows(verdicts: Sequence[Verdict], command: str) -> list[Row]:
    """The targets."""
    sound = [one for one in verdicts if one.sound]
    accepted = 100.0 * sum(map(_accepted, sound)) / max(1, len(sound))
    false = sum(bool(one.false) for one in verdicts)
    return [
        at_most("sensors and cameras of which something false was stated", false, MOST_FALSE, "draws", command),
        at_least("sound sensors and cameras accepted", accepted, LEAST_ACCEPTED, "%", command, f"of {len(sound)}"),
    ]
