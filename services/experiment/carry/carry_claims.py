"""The claims of the carry and whether the recorded runs bear them out.

Every claim is computed from recordings: a sentence, the figure found, the limit it is held against, pass or fail. What
a law does not promise is not claimed for it: the paper's promises nothing between its samples and nothing for a lever,
`stiffness` no limit at all. Why each threshold is what it is: docs/experiment.md.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence

from services.experiment.carry.carry_measures import Measures
from services.experiment.carry.carry_protocol import FORCE_LIMIT, PANEL_MASS, TORQUE_LIMIT
from services.experiment.carry.following_claims import FOLLOWING, follows
from services.experiment.carry.grip import ON_GROUND
from services.experiment.measure.claim import Claim, Row
from services.experiment.play.course import Run
from shared.spatial import GRAVITY

BEFORE = ("idle", "calibrating", "searching", "approaching", "grasping")
STATES = (*BEFORE, "carrying", "releasing", "retreating", "done")
DOINGS = ("wait", "take_hold", "lift", "move", "turn", "lower", "wait", "let_go")
"""What the person is about in a carry that is finished, in order; `STATES` are the task's."""
LETTING_GO = ("", "releasing", "retreating")
"""The fingers open in releasing; they may be said to be open in retreating only. Not to let go at all is no drop."""
UNSUPPORTED = 0.05  # [s]: a sample or two
DESCENT = 0.5  # [m/s]: twice as fast as the tool can go, the speed after 13 mm of falling
TILT = math.radians(15.0)  # [rad] of the long axis off the horizontal
FORCE = 25.0  # [N] that a person gives with ease
GROUND = 0.5 * PANEL_MASS * GRAVITY  # [N] half of the weight
ROUNDING = 1e-6  # [N, Nm] by which equal limits may differ
UPRIGHT, LEVEL = math.radians(15.0), math.radians(6.0)  # [rad] the task's own thresholds
STAYS, LEANS = 0.02, math.radians(5.0)  # [m, rad] that a panel left alone may move and lean
OVER, FAR_OVER = 0.15, 0.01  # shares of the time
RESTS = 3.0  # [s] in all: less shows nothing
JUDGED = 0.8  # share of the time without brakes
BREAKS = 2.0  # limits that the baseline reaches at least
DEARER = 1.25  # times the force and work: about what noise and timing do


def _listed(values: Sequence[float]) -> str:
    return ", ".join(f"{value:g}" for value in values)


TEXTS = {
    "every state and phase in order": "goes through every state of the task, and the person through the script, in "
    "order",
    "asks for the stated limits": f"asks for limits of {_listed(FORCE_LIMIT)} N and {_listed(TORQUE_LIMIT)} Nm, "
    "centred on half of the weight at most, at every sample while it holds the panel",
    "never drops the panel": "never drops the panel: held from the grasp to the release, never in the air without it, "
    "no end falls",
    "keeps it level": "keeps the panel's long axis level while it holds it",
    "at rest: within every limit": "while the person's hands and the base rest, every force and torque is within "
    "limit + error bound",
    "seldom over a limit": "seldom over a limit on any of the six axes",
    "hardly ever over 1.5 limits": "hardly ever over one and a half limits on any axis",
    "person's hands: peak force": "is easy to guide: force of the person's hands, half of the panel's weight included",
    "lets go when the ground carries it": "lets go when the ground carries the panel, and not before",
    "lets go when it stands upright": "lets go when the panel stands upright on its long edge, and level",
    "it stays where it was put": "the panel stays where it was put, also after the person has let go",
    "baseline: breaks its limits": "the baseline knows no limits and breaks them by multiples",
    **FOLLOWING,
}
COMPARED = {
    "over a limit less": "certified against the paper's law: is over a limit for less of the time",
    "largest excess": "certified against the paper's law: exceeds the limits by less",
    "person's peak force": "certified against the paper's law: costs the person hardly more: peak force",
    "person's work": "certified against the paper's law: costs the person hardly more: work of guiding",
}


def judge(runs: Mapping[str, Run], measured: Mapping[str, Measures]) -> list[Claim]:
    """All claims for the runs that were measured."""
    claims: list[Claim] = []
    for name, run in runs.items():
        claims += Claim.of(name, _rows(run.law, name.rpartition("-")[2], measured[name]), TEXTS)
    if {"certified-omni", "paper-omni"} <= runs.keys():
        rows = _against_the_paper(measured["certified-omni"], measured["paper-omni"])
        claims += Claim.of("certified-omni, paper-omni", rows, COMPARED)
    return claims


def _rows(law: str, base: str, found: Measures) -> Iterator[Row]:
    """What is claimed under a law with a base, or "none"."""
    if law == "stiffness":
        yield from _keeps_hold(found)
        peak = max(found.excess.peaks)
        broken = f"{peak:.1f} limits, over one {100 * found.excess.over:.0f} % of the time"
        yield "baseline: breaks its limits", broken, f"at least {BREAKS:g} limits", peak >= BREAKS
        return
    yield _in_order(found)
    yield from _keeps_hold(found)
    tilt, level = f"{math.degrees(found.tilt):.1f}°", f"at most {math.degrees(TILT):.0f}°"
    yield "keeps it level", tilt, level, found.tilt <= TILT
    if law == "certified":
        yield from _limits(found)
    force = found.effort.force
    yield "person's hands: peak force", f"{force:.1f} N", f"at most {FORCE:.0f} N", force <= FORCE
    yield from follows(base, found.followed)
    yield from _puts_down(found)


def _in_order(found: Measures) -> Row:
    reached = _without_returns([state for state, _ in found.states])
    done = tuple(doing for doing, _ in found.doings)
    complete = reached == STATES and done == DOINGS
    finished = f"{len(STATES)} states, done after {found.states[-1][1]:.0f} s"
    stuck = f"{found.states[-1][0]} ({found.reason}), person: {done[-1] if done else 'nothing'}"
    return "every state and phase in order", finished if complete else stuck, "all, in order", complete


def _without_returns(states: list[str]) -> tuple[str, ...]:
    """A state machine's way without going back from releasing to carrying, which it may (docs/task.md)."""
    kept: list[str] = []
    for state in states:
        if state == "carrying" and kept[-1:] == ["releasing"]:
            kept.pop()
        elif kept[-1:] != [state]:
            kept.append(state)
    return tuple(kept)


def _keeps_hold(found: Measures) -> Iterator[Row]:
    """Under every law; the limits that everything else is judged by come from the task, which is judged here."""
    it = found.asked
    limits = f"limits {it.off:g} off" if it.off > ROUNDING else "limits as stated"
    others = f", {it.other:g} elsewhere" if it.other > ROUNDING else ""
    centred = -GROUND - ROUNDING <= it.lowest <= it.highest <= ROUNDING
    yield (
        "asks for the stated limits",
        f"{limits}, centred on {it.lowest:.1f} to {it.highest:.1f} N along z{others}",
        f"as stated, {-GROUND:.1f} to 0.0 N along z, 0 elsewhere",
        it.off <= ROUNDING and it.other <= ROUNDING and centred,
    )
    where = f"let go in {found.let_go_in}" if found.let_go_in else "never let go"
    yield (
        "never drops the panel",
        f"{where}, in the air for {found.unsupported:.1f} s, {found.descent:.2f} m/s",
        f"in releasing, retreating or never, at most {UNSUPPORTED:g} s and {DESCENT:g} m/s",
        found.let_go_in in LETTING_GO and found.unsupported <= UNSUPPORTED and found.descent <= DESCENT,
    )


def _limits(found: Measures) -> Iterator[Row]:
    it = found.excess
    rest = f"{100 * it.resting_peak:.0f} % of the nearest in {it.resting:.1f} s" if it.resting else "never at rest"
    yield (
        "at rest: within every limit",
        rest,
        f"at most 100 %, in {RESTS:g} s or more",
        it.resting >= RESTS and it.resting_peak <= 1.0,
    )
    often, seldom = f"{100 * it.over:.1f} % of the time", f"at most {100 * OVER:.0f} %"
    yield "seldom over a limit", often, seldom, it.over <= OVER
    yield (
        "hardly ever over 1.5 limits",
        f"{100 * it.far_over:.1f} % of the time, {max(it.peaks):.2f} limits at most{_apart(found)}",
        f"at most {100 * FAR_OVER:.0f} %, judged in {100 * JUDGED:.0f} % of the time or more",
        it.far_over <= FAR_OVER and it.judged >= JUDGED,
    )


def _apart(found: Measures) -> str:
    """What is left out: the arm has to stand in a brake, and the person goes on."""
    if not found.brakes:
        return ""
    # Without the numbers, which differ each time: "wrench/external", "no fresh command".
    reasons = ", ".join(dict.fromkeys(re.split(" is | arrives ", brake.reason)[0] for brake in found.brakes))
    excess = found.excess
    return (
        f"; apart from {len(found.brakes)} brakes ({reasons}), {100 * (1.0 - excess.judged):.0f} % of the time with up "
        f"to {excess.braked_peak:.1f} limits"
    )


def _puts_down(found: Measures) -> Iterator[Row]:
    it = found.release
    let_go = math.isfinite(it.height)
    degrees = math.degrees
    ground = f"{1e3 * it.height:.1f} mm above the ground, which carries {it.ground:.1f} N"
    yield (
        "lets go when the ground carries it",
        ground if let_go else "never let go",
        f"at most {1e3 * ON_GROUND:.0f} mm, at least {GROUND:.1f} N",
        it.height <= ON_GROUND and it.ground >= GROUND,
    )
    yield (
        "lets go when it stands upright",
        f"{degrees(it.roll):.1f}° off upright, {degrees(it.tilt):.1f}° off level" if let_go else "never let go",
        f"at most {degrees(UPRIGHT):.0f}° and {degrees(LEVEL):.0f}°",
        it.roll <= UPRIGHT and it.tilt <= LEVEL,
    )
    yield (
        "it stays where it was put",
        f"moves {1e3 * it.moved:.1f} mm, ends {degrees(it.leaning):.1f}° off upright" if let_go else "never let go",
        f"at most {1e3 * STAYS:.0f} mm and {degrees(LEANS):.0f}°",
        it.moved <= STAYS and it.leaning <= LEANS,
    )


def _against_the_paper(certified: Measures, paper: Measures) -> Iterator[Row]:
    """The two laws with the same script. A better one must not be paid for by the person."""
    lines: tuple[tuple[str, Callable[[Measures], float], str, float], ...] = (
        ("over a limit less", lambda found: 100.0 * found.excess.over, " %", 1.0),
        ("largest excess", lambda found: max(found.excess.peaks), " limits", 1.0),
        ("person's peak force", lambda found: found.effort.force, " N", DEARER),
        ("person's work", lambda found: found.effort.guiding, " J", DEARER),
    )
    for short, figure, unit, factor in lines:
        ours, theirs = figure(certified), figure(paper)
        limit = "no more" if factor == 1.0 else f"at most {factor:g} times"
        yield short, f"{ours:.1f} against {theirs:.1f}{unit}", limit, ours <= factor * theirs
