"""The figures of the runs side by side: what each cost and kept, axis by axis, movement by movement."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence

from services.experiment.carry.carry_measures import Measures
from services.experiment.carry.excess import AXES, FAR_OVER
from services.experiment.carry.following import Followed
from services.experiment.measure.claim import Table

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
            "Movement by movement (shares of what the person wants, lags behind his wish)",
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
