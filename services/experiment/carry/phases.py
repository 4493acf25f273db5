"""The parts of a carry, named for people, as the figures mark them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes

from services.experiment.carry.carry_measures import Measures

_NAMES = {"lift": "lift", "lower": "lower", "let_go": "let go"}  # of what the person is about
_SHADE = "#F0F0F0"


@dataclass(frozen=True)
class Part:
    """Something that takes place from `start` to `end` [s]."""

    name: str
    start: float
    end: float


def parts(found: Measures) -> list[Part]:
    """Grasp, what the person does with the panel, and release, in order of time."""
    found_parts = [Part(one.name, one.start, one.end) for one in found.followed if np.isfinite(one.start)]
    for named, names in (
        (found.doings, _NAMES),
        (found.states, {"grasping": "grasp", "releasing": "release"}),
    ):
        for (name, start), (_, end) in zip(named, [*named[1:], ("", found.states[-1][1])], strict=True):
            if name in names and end > start:
                found_parts.append(Part(names[name], start, end))
    return sorted(found_parts, key=lambda part: part.start)


def mark(panels: Sequence[Axes], found: Measures) -> None:
    """Shades the parts in all panels, whose time axis is as it will be, and names them above the first one."""
    first, last = panels[0].get_xlim()
    for part in parts(found):
        if not first <= 0.5 * (part.start + part.end) <= last:
            continue
        for axes in panels:
            axes.axvspan(max(part.start, first), min(part.end, last), color=_SHADE, linewidth=0, zorder=0)
        panels[0].annotate(
            part.name,
            (0.5 * (part.start + part.end), 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(-2, 4),
            textcoords="offset points",
            rotation=50,
            rotation_mode="anchor",
            fontsize=8,
            color="#444444",
            annotation_clip=False,
        )
