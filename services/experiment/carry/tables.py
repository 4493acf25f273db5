"""The figures of the runs side by side: what each cost and kept, axis by axis, movement by movement."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from services.experiment.carry.excess import AXES
from services.experiment.carry.following import Followed
from services.experiment.carry.measures import Measures
from services.experiment.table import Table

NONE = "–"  # where there is no such figure


def tables(measured: Mapping[str, Measures]) -> list[Table]:
    """All of them, the comparison first."""
    return [
        Table(
            "The runs side by side",
            (
                "run",
                "done after",
                "over a limit",
                "over 1.5",
                "largest, limits",
                "a limit active",
                "hands, force",
                "hands, torque",
                "work of guiding",
                "reaction",
            ),
            tuple((name, *_compared(found)) for name, found in measured.items()),
        ),
        Table(
            "Limit by limit",
            ("run", "", *AXES),
            tuple(row for name, found in measured.items() for row in _limits(name, found)),
        ),
        Table(
            "Movement by movement",
            (
                "run",
                "movement",
                "wanted",
                "far end",
                "robot's end",
                "base",
                "lag",
                "base's lag",
                "reaction",
            ),
            tuple((name, *_movement(one)) for name, found in measured.items() for one in found.followed),
        ),
    ]


def _compared(found: Measures) -> Iterator[str]:
    excess, effort = found.excess, found.effort
    state, time = found.states[-1]
    yield f"{time:.0f} s" if state == "done" else f"not ({state})"
    yield _percent(excess.over)
    yield _percent(excess.far_over)
    yield f"{max(excess.peaks):.2f}"
    yield f"{100 * found.active:.0f} %"
    yield f"{effort.force:.1f} N"
    yield f"{effort.torque:.1f} Nm"
    yield f"{effort.guiding:.1f} J"
    yield _seconds(_slowest(found.followed))


def _limits(name: str, found: Measures) -> Iterator[tuple[str, ...]]:
    excess = found.excess
    yield name, "over it", *(_percent(share) for share in excess.over_each)
    yield name, "largest, limits", *(f"{peak:.2f}" for peak in excess.peaks)


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
    return NONE if math.isnan(share) else f"{100 * share:.0f} %"


def _seconds(time: float) -> str:
    if math.isnan(time):
        return NONE
    return f"{time:.2f} s" if math.isfinite(time) else "never"
