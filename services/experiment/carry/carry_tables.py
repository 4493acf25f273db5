"""What is told of the runs beside the claims: figures side by side, axis by axis, movement by movement; and notes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence

from services.experiment.carry.carry_measures import Measures
from services.experiment.carry.effort import HARD_TORQUE
from services.experiment.carry.excess import AFTER, AXES, BEFORE, FAR_OVER, REST_SPEED, REST_TURNING
from services.experiment.carry.following import Followed
from services.experiment.measure.claim import Table
from services.experiment.play.course import Run

NONE = "–"  # where there is no such figure


def tables(measured: Mapping[str, Measures]) -> list[Table]:
    """All of them, the comparison first."""
    movements = ("movement", "wanted", "far end", "robot's end", "base", "lag", "base's lag", "reaction")
    return [
        Table(
            "The runs side by side (shares of the time, any axis; peaks)",
            ("", *measured),
            tuple(_compared(list(measured.values()))),
        ),
        Table(
            "Limit by limit (share of the time over it, largest load)",
            ("run", "", *AXES),
            tuple(row for name, found in measured.items() for row in _limits(name, found)),
        ),
        Table(
            "Movement by movement (shares of what the person wants, lags behind that wish)",
            ("run", *movements),
            tuple((name, *_movement(one)) for name, found in measured.items() for one in found.followed),
        ),
    ]


def _compared(found: Sequence[Measures]) -> Iterator[tuple[str, ...]]:
    figures: tuple[tuple[str, Callable[[Measures], str]], ...] = (
        ("done after", _done),
        ("over a limit", lambda one: _percent(one.excess.over)),
        (f"over {FAR_OVER:g} limits", lambda one: _percent(one.excess.far_over)),
        ("largest", lambda one: f"{max(one.excess.peaks):.2f} limits"),
        ("a limit is active", lambda one: f"{100 * one.active:.0f} %"),
        ("hands' force", lambda one: f"{one.effort.force:.1f} N"),
        ("hands' torque", lambda one: f"{one.effort.torque:.1f} Nm"),
        ("work of guiding", lambda one: f"{one.effort.guiding:.1f} J"),
        ("slowest reaction", lambda one: _seconds(_slowest(one.followed))),
    )
    return ((name, *(figure(one) for one in found)) for name, figure in figures)


def _done(found: Measures) -> str:
    state, time = found.states[-1]
    return f"{time:.0f} s" if state == "done" else f"not ({state})"


def _limits(name: str, found: Measures) -> Iterator[tuple[str, ...]]:
    excess = found.excess
    yield name, "over", *(_percent(share) for share in excess.over_each)
    yield name, "largest", *(f"{peak:.2f} x" for peak in excess.peaks)


def _movement(one: Followed) -> Iterator[str]:
    yield one.name
    yield f"{math.degrees(one.wanted):.0f}°" if one.way == "roll" else f"{one.wanted:.2f} m"
    yield from (_share(share) for share in (one.far, one.near, one.base))
    yield from (_seconds(time) for time in (one.lag, one.base_lag, one.reaction))


def _slowest(followed: Sequence[Followed]) -> float:
    """Of push and pull; sideways the robot's end waits for a torque."""
    times = [one.reaction for one in followed if one.way == "along"]
    return max(times) if not any(map(math.isnan, times)) else math.nan


def _percent(share: float) -> str:
    return f"{100 * share:.1f} %"


def _share(share: float) -> str:
    return NONE if math.isnan(share) else f"{round(100 * share)} %"


def _seconds(time: float) -> str:
    if math.isnan(time):
        return NONE
    return f"{time:.2f} s" if math.isfinite(time) else "never"


def sentence(run: Run, found: Measures) -> str:
    """What became of a run, in one sentence that goes on after its title."""
    state, time = found.states[-1]
    end = f"has carried it and let go after {time:.0f} s" if state == "done" else f"ends {state} ({found.reason})"
    excess, effort = found.excess, found.effort
    return (
        f"{end}, over a limit for {_percent(excess.over)} of the time, {max(excess.peaks):.2f} limits at most; the "
        f"person needs {effort.force:.1f} N and {effort.torque:.1f} Nm, and {effort.guiding:.1f} J to guide it."
    )


def notes(measured: Mapping[str, Measures]) -> list[str]:
    """What a reader has to know to judge the claims, one line each."""
    return [
        "The limits are promised while the person and the base rest: while the hands move at most "
        f"{1e3 * REST_SPEED:.0f} mm/s and {REST_TURNING:g} rad/s relative to the base. While they move, nothing can "
        "keep a limit by itself; the excess that the motion accounts for is c |Kbar u| (D + u/2a), axis by axis, with "
        "c, Kbar, D and a as `tandem certify` has them. c is measured, not proven.",
        "u is the motion of the person's hands as the simulation knows it, relative to the base and taken at the tool, "
        f"in all six directions, the fastest from {BEFORE:g} s before a sample to {AFTER:g} s after it. What the base "
        "moves is in it: a person with whom the base keeps pace does not move relative to it.",
        *(_allowance(name, found) for name, found in measured.items() if math.isfinite(found.excess.used)),
        "This allowance is wide, because a torque limit of 0.5 Nm is small and a panel long: hardly any law would use "
        "it up, so nothing is claimed about it. That the excess is small is what the shares of the time over one and "
        "over one and a half limits show.",
        *(_effort(name, found) for name, found in measured.items()),
        f"Lowering the robot's end takes more than {HARD_TORQUE:g} Nm of the person's hands for seconds, under every "
        "law: the robot gives way to a torque, and the person stands at the far end. That is more than anybody "
        "likes to give for long; the simulated person has 20 Nm.",
        "Panel, hands and ground are the simulation's own account (sim/world); the rest is measured as on a robot.",
    ]


def _allowance(name: str, found: Measures) -> str:
    excess = found.excess
    speed, turning = excess.fastest
    axes = ", ".join(
        f"{axis} {peak:.2f} of {allowed:.1f}"
        for axis, peak, allowed in zip(AXES, excess.peaks, excess.allowed, strict=True)
    )
    return (
        f"{name}: hands at up to {speed:.2f} m/s and {turning:.2f} rad/s relative to the base. Of the excess that they "
        f"account for, {100 * excess.used:.0f} % was found at most. Largest, in limits: {axes}."
    )


def _effort(name: str, found: Measures) -> str:
    it = found.effort
    return (
        f"{name}: hands at most {it.force:.1f} N ({it.guiding_force:.1f} N horizontally while guiding) and "
        f"{it.torque:.1f} Nm (over {HARD_TORQUE:g} Nm for {it.hard:.1f} s); work {it.guiding:.1f} J of guiding; in all "
        f"{it.work:.1f} J, of which half of the weight {it.lifting:.1f} J, since the panel ends lower than it began. "
        f"Over a limit {100 * found.excess.over:.1f} % of the time ({100 * found.excess.surely_over:.1f} % for sure), "
        f"at most {max(found.excess.peaks):.2f} limits; some limit shaped the motion {100 * found.active:.0f} % of "
        "the time."
    )
