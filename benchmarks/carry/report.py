"""What a sweep prints."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.carry.cases import HARDER_KINDS, KINDS, Case
from benchmarks.carry.judge import Verdict
from benchmarks.carry.play import Played
from services.experiment.carry.excess import AXES

Result = tuple[Case, Verdict]


def line(case: Case, verdict: Verdict) -> str:
    """One case in one line."""
    drawn = " ".join(f"{name} {value}" for name, value in case.drawn.items())
    worst = int(np.argmax(verdict.peak))
    text = f"{case.seed} {case.kind}: {verdict.word}"
    if verdict.time is not None:
        text += f" in {verdict.time:.0f} s"
    if verdict.told:
        text += f", told to {', '.join(verdict.told)}"
    if verdict.gap is not None:
        text += f", opened {100 * verdict.gap:.1f} cm above the ground with {verdict.carried:.1f} N"
    text += f", peak {verdict.peak[worst]:.1f} {AXES[worst]}, over {100 * max(verdict.share):.0f} %"
    text += f", hands' springs {verdict.strain[0]:.1f} N {verdict.strain[1]:.1f} Nm [{drawn}]"
    if not verdict.completed:
        text += f" -- {verdict.end}: {verdict.reason} {verdict.trouble}".rstrip()
    return text


def trace(played: Played) -> None:
    """One case with its states and reasons."""
    print(f"settings: {played.case.run.settings}")
    for event in played.events:
        print(f"{event.time:8.2f} {event.name:22} {event.detail}")
    verdict = played.verdict
    for name, share, peak in zip(AXES, verdict.share, verdict.peak, strict=True):
        print(f"{name}: over its limit for {100 * share:.1f} % of the time, {peak:.2f} limits at most")
    print(f"largest tilt {math.degrees(verdict.tilt):.0f} degrees; stands at the end: {verdict.stands}")
    print(line(played.case, verdict))


def show(results: Sequence[Result], took: float, jobs: int) -> None:
    """The table, and what failed."""
    verdicts = [verdict for _, verdict in results]
    table = Table(title=f"{len(results)} carries, {took / 60:.0f} min with {jobs} jobs", title_justify="left")
    table.add_column("kind")
    for column in _row(verdicts):
        table.add_column(column, justify="right")
    for kind in (*dict.fromkeys((*KINDS, *HARDER_KINDS)), "all"):
        chosen = [verdict for case, verdict in results if kind in ("all", case.kind)]
        if chosen:
            table.add_row(kind, *_row(chosen).values())
    Console(width=160).print(table)
    print(headline(verdicts))
    by_axis = np.array([verdict.peak for verdict in verdicts])
    shares = np.array([verdict.share for verdict in verdicts])
    print("        " + "".join(f"{name:>8}" for name in AXES))
    for text, values in (
        ("peak 50%", np.median(by_axis, axis=0)),
        ("peak 95%", np.quantile(by_axis, 0.95, axis=0)),
        ("peak max", by_axis.max(axis=0)),
        ("over, %", 100 * shares.mean(axis=0)),
    ):
        print(f"{text:8}" + "".join(f"{value:8.2f}" for value in values))
    for case, verdict in results:
        if not verdict.as_it_should:
            print(line(case, verdict))


def headline(verdicts: Sequence[Verdict]) -> str:
    """What became of all of them, in a line that leaves nothing out."""
    found = _tally(verdicts)
    restarted = found["completed"] - found["of them without help"] - found["after release"]
    return (
        f"{found['completed']} of {found['carries']} completed: {found['of them without help']} without help, "
        f"{found['after release']} after somebody said `tandem task release`, {restarted} after `tandem resume` and "
        f"`tandem task start`; {found['held safely']} held safely; {found['not']} not completed; {found['dropped']} "
        f"dropped ({found['of them torn out']} of them torn out by a person who let go although the task had warned); "
        f"{found['early']} let go of early"
    )


def _tally(verdicts: Sequence[Verdict]) -> dict[str, int]:
    completed = [verdict.told for verdict in verdicts if verdict.completed]
    return {
        "carries": len(verdicts),
        "completed": len(completed),
        "of them without help": sum(not told for told in completed),
        "after release": sum("release" in told for told in completed),
        "held safely": sum(verdict.safe for verdict in verdicts),
        "not": sum(verdict.word in ("NOT COMPLETED", "FELL OVER") for verdict in verdicts),
        "dropped": sum(verdict.dropped for verdict in verdicts),
        "of them torn out": sum(verdict.torn for verdict in verdicts),
        "early": sum(verdict.early for verdict in verdicts),
    }


def _row(verdicts: Sequence[Verdict]) -> dict[str, str]:
    """The table's columns and their cells for some carries."""
    times = [verdict.time for verdict in verdicts if verdict.time is not None]
    peaks = [max(verdict.peak) for verdict in verdicts]
    force, torque = np.mean([verdict.strain for verdict in verdicts], axis=0)
    return {
        **{name: str(count) for name, count in _tally(verdicts).items()},
        "median s": f"{np.median(times):.0f}" if times else "-",
        "median peak, limits": f"{np.median(peaks):.2f}",
        "largest peak": f"{max(peaks):.2f}",
        "over limit, median %": f"{100 * np.median([max(verdict.share) for verdict in verdicts]):.1f}",
        "hands' springs N, Nm": f"{force:.1f}, {torque:.1f}",
    }
