"""The claims of the load experiment and whether the recorded runs bear them out.

Every claim is computed from recordings: a sentence, the figure found, the limit it is held against, pass or fail.
What a law does not promise is not claimed for it: `stiffness` is the baseline and is expected to sag.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from services.experiment.load.load_measures import GROUND, Measures
from services.experiment.load.load_protocol import FORCE_LIMIT, LIGHT
from services.experiment.measure.claim import Claim, Row
from services.experiment.play.course import Run

HOLD_WITHIN = 0.010  # [m] that the light bag may move the tool
SAG_AT_LEAST = 0.1  # [m]: "sags by decimetres"
RETURN_WITHIN = 0.010  # [m] off the pose after the bag was taken off
STEADY_WITHIN = 1.0  # [N]: twice the sensor's error bound
LEAST_WAY = 0.4
"""Share of the way without brakes: with a fifth taken off, a swing's middle half is still seen."""
SPEED_SLACK = 1.05  # the tool's tracking may overshoot the commanded speed by this factor
SAGS, HOLDS = f"cannot hold {LIGHT:.0f} N: sags", f"holds {LIGHT:.0f} N: tool z moves"
TEXTS = {
    SAGS: f"the baseline cannot hold {LIGHT:.0f} N: it sags by decimetres",
    HOLDS: f"holds {LIGHT:.0f} N: the tool moves less than 1 cm in z",
    "keeps every limit until then": "stays within every limit, force and torque, until the heavier bag",
    "lowers the heavier bag": "lowers the heavier bag to the ground",
    "smoothly: no turning back": "lowers it smoothly: always downward, never over the tool's speed limit",
    "leaves it on the ground": "leaves it on the ground",
    "load steady on the way": "carries it steadily: but for a fifth of the way down and brakes, the load does not "
    "swing",
    "load then within limit + error": "once the ground bears the rest, the load is within limit + error bound",
    "comes back when unloaded": "comes back to the pose it held when the bag is taken off",
}
_WORSE = "under certified than under the paper's law"
COMPARED = {
    "load on the way: swings less": f"but for a fifth of the way down and brakes, the load swings less {_WORSE}",
    "load on the ground: peaks lower": f"the load peaks lower with the bag on the ground {_WORSE}",
    "tool on the ground: steadier": "with the bag on the ground the tool rests more steadily (standard deviation of z) "
    f"{_WORSE}",
}


def judge(runs: Mapping[str, Run], measured: Mapping[str, Measures]) -> list[Claim]:
    """All claims for the runs that were measured."""
    claims: list[Claim] = []
    for name, run in runs.items():
        claims += Claim.of(name, _rows(run.law, measured[name]), TEXTS)
    if {"paper-30", "certified-30"} <= runs.keys():
        rows = _against_the_paper(measured["paper-30"], measured["certified-30"])
        claims += Claim.of("certified-30, paper-30", rows, COMPARED)
    return claims


def _rows(law: str, found: Measures) -> Iterator[Row]:
    if law == "stiffness":
        sag, least = f"{1e3 * found.sag:.0f} mm", f"at least {1e3 * SAG_AT_LEAST:.0f} mm"
        yield SAGS, sag, least, found.sag >= SAG_AT_LEAST
    else:
        yield from _keeps_and_lowers(found)
    if law == "certified":
        yield from _certified(found)
    yield (
        "comes back when unloaded",
        f"{1e3 * found.return_error:.1f} mm off ({found.return_time:.1f} s)",
        f"within {1e3 * RETURN_WITHIN:.0f} mm",
        found.return_error <= RETURN_WITHIN,
    )


def _keeps_and_lowers(found: Measures) -> Iterator[Row]:
    error, within = f"{1e3 * found.hold_error:.1f} mm", f"under {1e3 * HOLD_WITHIN:.0f} mm"
    yield HOLDS, error, within, found.hold_error < HOLD_WITHIN
    nearest = f"{100 * found.excess_before:.0f} % of the nearest"
    yield "keeps every limit until then", nearest, "at most 100 %", found.excess_before <= 1.0
    landed = math.isfinite(found.landing)
    way = f"{1e3 * found.drop:.0f} mm in {found.lowering_time:.1f} s" if landed else "never"
    yield "lowers the heavier bag", way, "in time", landed
    yield (
        "smoothly: no turning back",
        f"{found.reversals} turns, {1e3 * found.peak_speed:.0f} mm/s",
        f"0, at most {1e3 * found.max_linear:.0f} mm/s",
        found.reversals == 0 and found.peak_speed <= SPEED_SLACK * found.max_linear,
    )
    height, ground = f"{1e3 * found.bag_height:.1f} mm above it", f"at most {1e3 * GROUND:.0f} mm"
    yield "leaves it on the ground", height, ground, found.bag_height <= GROUND


def _certified(found: Measures) -> Iterator[Row]:
    steady = found.load_swing <= STEADY_WITHIN and found.judged_way >= LEAST_WAY
    yield "load steady on the way", _swing(found), f"±{STEADY_WITHIN:.0f} N", steady
    allowed, peak = FORCE_LIMIT[2] + found.error_bound, found.ground_peak
    figure = f"{peak:.2f} N" if math.isfinite(peak) else "never there"
    yield "load then within limit + error", figure, f"{allowed:.2f} N", peak <= allowed


def _swing(found: Measures) -> str:
    """The load's swing, and every brake on the way with its reason: a load is never steady after one."""
    swing = f"±{found.load_swing:.2f} N" if found.judged_way >= LEAST_WAY else "too little without brakes"
    if not found.brakes:
        return swing
    count = len(found.brakes)
    reasons = "; ".join(dict.fromkeys(brake.reason for brake in found.brakes))
    return f"{swing}, {count} brake{'s' if count > 1 else ''}: {reasons}"


def _against_the_paper(paper: Measures, certified: Measures) -> Iterator[Row]:
    """The two laws at the paper's own rate. A comparison holds only if the certified law is no worse."""
    for short, name, scale, unit, digits in (
        ("load on the way: swings less", "load_swing", 1.0, "N", 2),
        ("load on the ground: peaks lower", "ground_peak", 1.0, "N", 1),
        ("tool on the ground: steadier", "ground_ripple", 1e3, "mm", 2),
    ):
        ours, theirs = (scale * getattr(found, name) for found in (certified, paper))
        figure = f"{ours:.{digits}f} against {theirs:.{digits}f} {unit}"
        there = math.isfinite(ours) and math.isfinite(theirs)
        yield short, figure if there else "never there", "no worse", there and ours <= theirs
