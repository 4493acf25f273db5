"""The claims of the load experiment and whether the recorded runs bear them out.

Every claim is computed from recordings: a sentence, the figure found, the limit it is held against, pass or fail.
What a law does not promise is not claimed for it: `stiffness` is the baseline and is expected to sag.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from services.experiment.load.load_measures import GROUND, Measures
from services.experiment.load.load_protocol import FORCE_LIMIT, LIGHT
from services.experiment.measure.claim import Claim, Row
from services.experiment.play.course import Run

HOLD_WITHIN = 0.010  # [m]
SAG_AT_LEAST = 0.1  # [m]: "sags by decimetres"
RETURN_WITHIN = 0.010  # [m]
STEADY_WITHIN = 1.0  # [N]: twice the sensor's error bound
LEAST_WAY = (
    0.4  # share of the way without brakes: with a fifth taken off, a swing's middle half is still seen
)
SPEED_SLACK = 1.05  # the tool's tracking may overshoot the commanded speed by this factor


def judge(runs: Mapping[str, Run], measured: Mapping[str, Measures]) -> list[Claim]:
    """All claims for the runs that were measured."""
    claims: list[Claim] = []
    for name, run in runs.items():
        found = measured[name]
        rows = [_sags(found)] if run.law == "stiffness" else _keeps_and_lowers(found)
        if run.law == "certified":
            rows += _certified(found)
        claims += Claim.of(name, [*rows, _comes_back(found)])
    if {"paper-30", "certified-30"} <= runs.keys():
        rows = _against_the_paper(measured["paper-30"], measured["certified-30"])
        claims += Claim.of("certified-30, paper-30", rows)
    return claims


def _sags(found: Measures) -> Row:
    return (
        f"cannot hold {LIGHT:.0f} N: sags",
        f"the baseline cannot hold {LIGHT:.0f} N: it sags by decimetres",
        f"{1e3 * found.sag:.0f} mm",
        f"at least {1e3 * SAG_AT_LEAST:.0f} mm",
        found.sag >= SAG_AT_LEAST,
    )


def _keeps_and_lowers(found: Measures) -> list[Row]:
    landed = math.isfinite(found.landing)
    return [
        (
            f"holds {LIGHT:.0f} N: tool z moves",
            f"holds {LIGHT:.0f} N: the tool moves less than 1 cm in z",
            f"{1e3 * found.hold_error:.1f} mm",
            f"under {1e3 * HOLD_WITHIN:.0f} mm",
            found.hold_error < HOLD_WITHIN,
        ),
        (
            "keeps every limit until then",
            "stays within every limit, force and torque, until the heavier bag",
            f"{100 * found.excess_before:.0f} % of the nearest",
            "at most 100 %",
            found.excess_before <= 1.0,
        ),
        (
            "lowers the heavier bag",
            "lowers the heavier bag to the ground",
            f"{1e3 * found.drop:.0f} mm in {found.lowering_time:.1f} s" if landed else "never",
            "in time",
            landed,
        ),
        (
            "smoothly: no turning back",
            "lowers it smoothly: always downward, never over the tool's speed limit",
            f"{found.reversals} turns, {1e3 * found.peak_speed:.0f} mm/s",
            f"0, at most {1e3 * found.max_linear:.0f} mm/s",
            found.reversals == 0 and found.peak_speed <= SPEED_SLACK * found.max_linear,
        ),
        (
            "leaves it on the ground",
            "leaves it on the ground",
            f"{1e3 * found.bag_height:.1f} mm above it",
            f"at most {1e3 * GROUND:.0f} mm",
            found.bag_height <= GROUND,
        ),
    ]


def _certified(found: Measures) -> list[Row]:
    allowed = FORCE_LIMIT[2] + found.error_bound
    landed = math.isfinite(found.ground_peak)
    return [
        (
            "load steady on the way",
            "carries it steadily: but for a fifth of the way down and brakes, the load does not swing",
            _swing(found),
            f"±{STEADY_WITHIN:.0f} N",
            found.load_swing <= STEADY_WITHIN and found.judged_way >= LEAST_WAY,
        ),
        (
            "load then within limit + error",
            "once the ground bears the rest, the load is within limit + error bound",
            f"{found.ground_peak:.2f} N" if landed else "never there",
            f"{allowed:.2f} N",
            found.ground_peak <= allowed,
        ),
    ]


def _swing(found: Measures) -> str:
    """The load's swing, and every brake on the way with its reason: a load is never steady after one."""
    swing = f"±{found.load_swing:.2f} N" if found.judged_way >= LEAST_WAY else "too little without brakes"
    if not found.brakes:
        return swing
    count = len(found.brakes)
    reasons = "; ".join(dict.fromkeys(brake.reason for brake in found.brakes))
    return f"{swing}, {count} brake{'s' if count > 1 else ''}: {reasons}"


def _comes_back(found: Measures) -> Row:
    return (
        "comes back when unloaded",
        "comes back to the pose it held when the bag is taken off",
        f"{1e3 * found.return_error:.1f} mm off ({found.return_time:.1f} s)",
        f"within {1e3 * RETURN_WITHIN:.0f} mm",
        found.return_error <= RETURN_WITHIN,
    )


def _against_the_paper(paper: Measures, certified: Measures) -> list[Row]:
    """The two laws at the paper's own rate. A comparison holds only if the certified law is no worse."""
    way, ground = "but for a fifth of the way down and brakes, the load", "with the bag on the ground"
    lines = (
        ("load on the way: swings less", f"{way} swings less", "load_swing", 1.0, "N", 2),
        ("load on the ground: peaks lower", f"the load peaks lower {ground}", "ground_peak", 1.0, "N", 1),
        (
            "tool on the ground: steadier",
            f"{ground} the tool rests more steadily (standard deviation of z)",
            *("ground_ripple", 1e3, "mm", 2),
        ),
    )
    rows = []
    for short, text, name, scale, unit, digits in lines:
        ours, theirs = (scale * getattr(found, name) for found in (certified, paper))
        figure = f"{ours:.{digits}f} against {theirs:.{digits}f} {unit}"
        rows.append(
            (short, f"{text} under certified than under the paper's law", figure, "no worse", ours <= theirs)
        )
    return rows
