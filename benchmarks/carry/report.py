"""What a sweep prints."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.carry.cases import KINDS, Case
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
    table = Table(title=f"{len(results)} carries, {took / 60:.0f} min with {jobs} jobs", title_justify="left")
    for column in (
        "kind",
        "carries",
        "completed",
        "of them without help",
        "after release",
        "held safely",
        "not",
        "dropped",
        "of them torn out",
        "early",
        "median s",
        "median peak, limits",
        "largest peak",
        "over limit, median %",
        "hands' springs N, Nm",
    ):
        table.add_column(column, justify="left" if column == "kind" else "right")
    for kind in (*dict.fromkeys(KINDS), "all"):
        chosen = [result for result in results if kind in ("all", result[0].kind)]
        if chosen:
            table.add_row(kind, *_cells([verdict for _, verdict in chosen]))
    Console(width=160).print(table)
    print(headline([verdict for _, verdict in results]))
    by_axis = np.array([verdict.peak for _, verdict in results])
    shares = np.array([verdict.share for _, verdict in results])
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
    completed = [verdict.told for verdict in verdicts if verdict.completed]
    alone = sum(not told for told in completed)
    released = sum("release" in told for told in completed)
    restarted = sum(bool(told) and "release" not in told for told in completed)
    dropped = sum(verdict.dropped for verdict in verdicts)
    torn = sum(verdict.torn for verdict in verdicts)
    ended = sum(verdict.completed or verdict.safe or verdict.dropped or verdict.early for verdict in verdicts)
    return (
        f"{len(completed)} of {len(verdicts)} completed: {alone} without help, {released} after "
        f"somebody said `tandem task release`, {restarted} after `tandem resume` and `tandem task start`; "
        f"{sum(verdict.safe for verdict in verdicts)} held safely; {len(verdicts) - ended} not completed; {dropped} "
        f"dropped ({torn} of them torn out by a person who let go although the task had warned); "
        f"{sum(verdict.early for verdict in verdicts)} let go of early"
    )


def _cells(verdicts: Sequence[Verdict]) -> list[str]:
    times = [verdict.time for verdict in verdicts if verdict.time is not None]
    peaks = [max(verdict.peak) for verdict in verdicts]
    completed = [verdict.told for verdict in verdicts if verdict.completed]
    force, torque = np.mean([verdict.strain for verdict in verdicts], axis=0)
    return [
        str(len(verdicts)),
        str(len(completed)),
        str(sum(not told for told in completed)),
        str(sum("release" in told for told in completed)),
        str(sum(verdict.safe for verdict in verdicts)),
        str(sum(verdict.word in ("NOT COMPLETED", "FELL OVER") for verdict in verdicts)),
        str(sum(verdict.dropped for verdict in verdicts)),
        str(sum(verdict.torn for verdict in verdicts)),
        str(sum(verdict.early for verdict in verdicts)),
        f"{np.median(times):.0f}" if times else "-",
        f"{np.median(peaks):.2f}",
        f"{max(peaks):.2f}",
        f"{100 * np.median([max(verdict.share) for verdict in verdicts]):.1f}",
        f"{force:.1f}, {torque:.1f}",
    ]
