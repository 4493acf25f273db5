"""The claims about how the robot follows the person who guides it.

A robot that holds one end of a panel cannot be shifted sideways by a person at the other end as it can be pushed and
pulled: 3 Nm at the tool are 2.5 N at 1.2 m. So sideways and turns are judged at the far end, where the person is.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from services.experiment.carry.following import Followed
from services.experiment.carry.protocol import GUIDANCE
from services.experiment.claim import Claim

MISSES, MISSES_TURN = 0.03, math.radians(3.0)  # [m, rad]
ALONG, TURNS = 0.9, 0.9  # shares of the far end's way
ACROSS = {"omni": 0.5, "differential": 0.2}
REACTS = 0.4  # [s]


def follows(run: str, followed: Sequence[Followed]) -> list[Claim]:
    """All of them for one run, named LAW-BASE."""
    base = run.rpartition("-")[2]
    way = {guidance.name: guidance.way for guidance in GUIDANCE[base]}
    along, across, rolls = (
        [one for one in followed if way[one.name] == kind] for kind in ("along", "across", "roll")
    )
    claims = [
        _gets_there(
            run,
            "far end gets where it is wanted",
            "the far end gets where the person wants it: push, pull, side to side",
            (*along, *across),
            MISSES,
            lambda miss: f"{1e3 * miss:.0f} mm",
        ),
        _gets_there(
            run,
            "turns where it is wanted",
            "the far end turns where the person wants it: twist and turn",
            rolls,
            MISSES_TURN,
            lambda miss: f"{math.degrees(miss):.1f}°",
        ),
        _least(run, "follows push and pull", "the robot's end follows push and pull", along, ALONG),
        _least(run, "follows the turns", "the robot's end follows twist and turn", rolls, TURNS),
    ]
    if base in ACROSS:
        text = "the robot's end comes along sideways, as far as torque at the far end can bring it"
        claims.append(_least(run, "comes along sideways", text, across, ACROSS[base]))
    slowest = max(along, key=lambda one: _or_infinite(one.reaction))
    claims.append(
        Claim(
            run,
            "reacts to push and pull",
            "moves soon after the person pushes or pulls",
            f"{slowest.reaction:.2f} s ({slowest.name})"
            if math.isfinite(slowest.reaction)
            else f"not at all ({slowest.name})",
            f"at most {REACTS:g} s",
            slowest.reaction <= REACTS,
        )
    )
    return claims


def _missing(one: Followed) -> float:
    return abs(1.0 - one.far) * abs(one.wanted)


def _or_infinite(value: float) -> float:
    return value if math.isfinite(value) else math.inf


def _gets_there(
    run: str,
    short: str,
    text: str,
    followed: Sequence[Followed],
    within: float,
    shown: Callable[[float], str],
) -> Claim:
    worst = max(followed, key=_missing)
    missing = _missing(worst)
    return Claim(
        run, short, text, f"{shown(missing)} off ({worst.name})", f"within {shown(within)}", missing <= within
    )


def _least(run: str, short: str, text: str, followed: Sequence[Followed], least: float) -> Claim:
    worst = min(followed, key=lambda one: one.near)
    return Claim(
        run,
        short,
        text,
        f"{100 * worst.near:.0f} % of the far end's way ({worst.name})",
        f"at least {100 * least:.0f} %",
        worst.near >= least,
    )
