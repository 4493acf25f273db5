"""The claims of the load experiment and whether the recorded runs bear them out.

Every claim is computed from recordings: a sentence, the figure found, the limit it is held against, pass or fail.
What a law does not promise is not claimed for it: `stiffness` is the baseline and is expected to sag.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from services.experiment.measures import GROUND, Measures
from services.experiment.protocol import LIGHT, Run

HOLD_WITHIN = 0.010  # [m]
SAG_AT_LEAST = 0.1  # [m]: "sags by decimetres"
RETURN_WITHIN = 0.010  # [m]
SPEED_SLACK = 1.05  # the tool's tracking may overshoot the commanded speed by this factor


@dataclass(frozen=True)
class Claim:
    """One line of the table. `run` is the run's name, or two names for a comparison."""

    run: str
    text: str
    figure: str
    limit: str
    passed: bool


def judge(runs: Mapping[str, Run], measured: Mapping[str, Measures], limit: float) -> list[Claim]:
    """All claims for the runs that were measured. `limit` [N] is the limit on force z."""
    claims: list[Claim] = []
    for name, run in runs.items():
        found = measured[name]
        claims += _baseline(run, found) if run.law == "stiffness" else _law(run, found, limit)
        claims.append(
            Claim(
                name,
                "comes back to the pose it held when the bag is taken off",
                f"{1e3 * found.return_error:.1f} mm away, after {found.return_time:.1f} s",
                f"within {1e3 * RETURN_WITHIN:.0f} mm",
                found.return_error <= RETURN_WITHIN,
            )
        )
    return claims + _comparisons(runs, measured)


def _baseline(run: Run, found: Measures) -> list[Claim]:
    return [
        Claim(
            run.name,
            f"the baseline cannot hold {LIGHT:.0f} N: it sags by decimetres",
            f"{1e3 * found.sag:.0f} mm",
            f"at least {1e3 * SAG_AT_LEAST:.0f} mm",
            found.sag >= SAG_AT_LEAST,
        )
    ]


def _law(run: Run, found: Measures, limit: float) -> list[Claim]:
    allowed = limit + found.error_bound
    claims = [
        Claim(
            run.name,
            f"holds {LIGHT:.0f} N: the tool moves less than 1 cm in z",
            f"{1e3 * found.hold_error:.1f} mm",
            f"under {1e3 * HOLD_WITHIN:.0f} mm",
            found.hold_error < HOLD_WITHIN,
        ),
        Claim(
            run.name,
            "stays within every limit, force and torque, until the heavier bag",
            f"{100 * found.excess_before:.0f} % of the nearest limit",
            "at most 100 %",
            found.excess_before <= 1.0,
        ),
        Claim(
            run.name,
            "lowers the heavier bag to the ground",
            f"{1e3 * found.drop:.0f} mm in {found.lowering_time:.1f} s"
            if found.landing == found.landing
            else "never",
            "before it is taken off",
            found.landing == found.landing,
        ),
        Claim(
            run.name,
            "lowers it smoothly: always downward, never over the tool's speed limit",
            f"{found.reversals} turn-rounds, peak {1e3 * found.peak_speed:.0f} mm/s",
            f"0 turn-rounds, {1e3 * found.max_linear:.0f} mm/s",
            found.reversals == 0 and found.peak_speed <= SPEED_SLACK * found.max_linear,
        ),
        Claim(
            run.name,
            "leaves it on the ground",
            f"{1e3 * found.bag_height:.1f} mm above it",
            f"at most {1e3 * GROUND:.0f} mm",
            found.bag_height <= GROUND,
        ),
    ]
    if run.law == "certified":
        claims.append(
            Claim(
                run.name,
                "with the ground bearing the rest, the load is back within limit + error bound",
                f"{found.ground_peak:.2f} N at most",
                f"{allowed:.2f} N",
                found.ground_peak <= allowed,
            )
        )
    return claims


def _comparisons(runs: Mapping[str, Run], measured: Mapping[str, Measures]) -> list[Claim]:
    claims = []
    if {"paper-30", "certified-30"} <= runs.keys():
        paper, certified = measured["paper-30"], measured["certified-30"]
        claims.append(
            Claim(
                "certified-30, paper-30",
                "with the bag on the ground, certified is no less steady than the paper's law at the same rate",
                f"tool z varies by {1e3 * certified.ground_ripple:.2f} against {1e3 * paper.ground_ripple:.2f} mm",
                "certified at most paper",
                certified.ground_ripple <= paper.ground_ripple,
            )
        )
    return claims
