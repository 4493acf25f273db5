"""The claims about how the robot follows the person who guides it.

Everything is held against what the person wants. Sideways a robot that holds one end of a panel cannot be shifted by a
person at the other end as it can be pushed and pulled: 3 Nm at the tool are 2.5 N at 1.2 m, and the rest is yaw.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from services.experiment.carry.following import Followed
from services.experiment.measure.claim import Row

MISSES, MISSES_TURN = 0.03, math.radians(3.0)  # [m, rad]
ARM = 0.15  # [m] of push and pull that the arm can make up for: it reaches from 0.45 to 0.6 m before the base
ACROSS = {"omni": 0.5, "differential": 0.2}  # shares of what is wanted
LAG, BASE_LAG = 0.33, 1.0  # [s]
REACTS = 0.4  # [s]

FOLLOWING = {
    "far end gets where it is wanted": "the far end gets where the person wants it: push, pull, side to side",
    "turns where it is wanted": "the far end turns where the person wants it: twist and turn",
    "robot's end follows push and pull": "the robot's end goes where the person wants the panel: push and pull",
    "robot's end follows the turns": "the robot's end turns as the person wants the panel turned: twist and turn",
    "robot's end keeps up": "the robot's end keeps up with the person's wish: push, pull, twist and turn, half-way",
    "base goes along": "the base goes along with push and pull, further than the arm could do without it",
    "base keeps up": "the base keeps up with the person's wish: push and pull, half-way",
    "comes along sideways": "the robot's end comes along sideways, as far as torque at the far end can bring it",
    "reacts to push and pull": "moves soon after the person's hands feel that they push or pull",
}

Figures = Sequence[tuple[Followed, float]]
"""Movements, each with a figure of it."""


def follows(base: str, followed: Sequence[Followed]) -> Iterator[Row]:
    """All of them for a run with a base, or "none"."""
    along, across, rolls = ([one for one in followed if one.way == way] for way in ("along", "across", "roll"))
    far, near = [(one, one.far) for one in (*along, *across)], [(one, one.near) for one in along]
    yield _gets_there("far end gets where it is wanted", far, MISSES)
    yield _gets_there("turns where it is wanted", [(one, one.far) for one in rolls], MISSES_TURN)
    yield _gets_there("robot's end follows push and pull", near, MISSES)
    yield _gets_there("robot's end follows the turns", [(one, one.near) for one in rolls], MISSES_TURN)
    yield _soon("robot's end keeps up", [(one, one.lag) for one in (*along, *rolls)], LAG)
    if base in ACROSS:
        yield _gets_there("base goes along", [(one, one.base) for one in along], ARM)
        yield _soon("base keeps up", [(one, one.base_lag) for one in along], BASE_LAG)
        worst, least = min(across, key=lambda one: one.near), ACROSS[base]
        way = f"{100 * worst.near:.0f} % of the way wanted ({worst.name})"
        yield "comes along sideways", way, f"at least {100 * least:.0f} %", worst.near >= least
    yield _soon("reacts to push and pull", [(one, one.reaction) for one in along], REACTS)


def _gets_there(short: str, shares: Figures, within: float) -> Row:
    """Of the shares of the ways, the one that lacks most."""
    worst, share = max(shares, key=lambda one: one[0].short(one[1]))
    missing = worst.short(share)
    lacks, allowed = (
        f"{math.degrees(value):.1f}°" if worst.way == "roll" else f"{1e3 * value:.0f} mm" for value in (missing, within)
    )
    return short, f"{lacks} off, {100 * share:.0f} % ({worst.name})", f"within {allowed}", missing <= within


def _soon(short: str, times: Figures, within: float) -> Row:
    worst, time = max(times, key=lambda one: one[1] if math.isfinite(one[1]) else math.inf)
    when = f"{time:.2f} s ({worst.name})" if math.isfinite(time) else f"not at all ({worst.name})"
    return short, when, f"at most {within:g} s", time <= within
