"""Figures of the carry: forces and torques, paths from above, heights and turns, and the laws side by side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from services.experiment.carry.carry_measures import Measures
from services.experiment.carry.carry_parts import parts
from services.experiment.carry.carry_protocol import PANEL_SIZE
from services.experiment.carry.effort import guiding_work
from services.experiment.carry.excess import Wrenches
from services.experiment.carry.motion import Motion
from services.experiment.play.course import Run
from services.experiment.play.recording import Recording
from services.experiment.report.drawing import (
    BLUE,
    FAINT,
    GREEN,
    INK,
    LIMIT_COLOUR,
    LIMIT_LINE,
    VERMILION,
    WIDTH,
    WINDOW,
    head,
    stacked,
)

COLOURS = {"certified": BLUE, "paper": VERMILION, "stiffness": GREEN}
STYLES: dict[str, Any] = {"certified": "-", "paper": (0, (4, 1.5)), "stiffness": (0, (1.5, 1))}
DIFFERENTIAL = (0, (6, 2, 1, 2))
SHOWN_BEFORE = 1.0  # [s] before the grasp
CUT_OFF = 3.0  # [limits] off the nominal wrench: what is further away would make the rest too small to be seen
BAND = 1.2  # [limits] that are shown at least
_LABELS = ("f$_x$ [N]", "f$_y$ [N]", "f$_z$ [N]", "t$_x$ [Nm]", "t$_y$ [Nm]", "t$_z$ [Nm]")
_FOOTPRINT = 0.27  # [m] radius of TIAGo's base
_SHADE = "#F0F0F0"


@dataclass(frozen=True)
class Frame:
    """The scales of all runs' figures, so that they can be held against each other.

    Attributes:
        time: from just before the first grasp to just after the last release [s].
        wrench: least and largest value (6, 2) [N, Nm] that is shown of each axis: up to `CUT_OFF` limits.
        ground: least and largest x and y (2, 2) [m] of base, tool, hands and panel from above.
        height: largest height [m] of the panel.
    """

    time: tuple[float, float]
    wrench: np.ndarray
    ground: np.ndarray
    height: float

    @classmethod
    def of(cls, recordings: Mapping[str, Recording], found: Mapping[str, Measures]) -> Frame:
        """Wide enough for all runs."""
        ends = {name: _end(recordings[name], it) for name, it in found.items()}
        wrenches = [Wrenches.of(recordings[name], it.held.start, ends[name]) for name, it in found.items()]
        furthest = [one.nominal + sign * CUT_OFF * one.limit for one in wrenches for sign in (-1, 1)]
        bands = np.vstack([one.nominal + sign * BAND * one.limit for one in wrenches for sign in (-1, 1)])
        values = np.vstack([one.wrench for one in wrenches])
        cut = np.clip(values, np.min(np.vstack(furthest), axis=0), np.max(np.vstack(furthest), axis=0))
        shown = np.vstack([bands, cut])
        points, heights = [], []
        for name, it in found.items():
            motion = Motion.of(recordings[name])
            held = (motion.time >= it.held.start) & (motion.time < ends[name])
            points += [path[held, :2] for path in (motion.base, motion.tool, motion.hand)]
            points += [_outline(motion, int(k)) for k in np.flatnonzero(held)[:: max(1, int(held.sum()) // 50)]]
            heights.append(float(motion.ends[held, :, 2].max()))
        ground = np.vstack(points)
        start = min(it.held.start for it in found.values())
        return cls(
            (start - SHOWN_BEFORE, max(ends.values()) + SHOWN_BEFORE),
            np.stack([shown.min(axis=0), shown.max(axis=0)], axis=1),
            np.stack([ground.min(axis=0) - _FOOTPRINT, ground.max(axis=0) + _FOOTPRINT], axis=1),
            1.1 * max(heights),
        )


def draw_wrench(run: Run, recording: Recording, found: Measures, frame: Frame) -> Figure:
    """The six axes of the wrench at the tool over time, with the band that the limits leave."""
    figure, panels = stacked(6, 9.6)
    wrenches = Wrenches.of(recording, found.held.start, _end(recording, found))
    time = wrenches.time
    for axis, axes in enumerate(panels):
        low, high = (wrenches.nominal + sign * wrenches.limit for sign in (-1, 1))
        value = wrenches.wrench[:, axis]
        for edge in (low[:, axis], high[:, axis]):
            axes.plot(time, edge, **LIMIT_LINE, zorder=4)
        axes.plot(time, value, color=BLUE, linewidth=0.7, zorder=3)
        over = (value < low[:, axis]) | (value > high[:, axis])
        axes.plot(time[over], value[over], ".", color=LIMIT_COLOUR, markersize=2.5, zorder=5, rasterized=True)
        axes.set_ylabel(_LABELS[axis])
        axes.set_ylim(*frame.wrench[axis])
    head(panels[0], run.title, pad=34)
    panels[-1].set_xlabel("time [s]")
    panels[-1].set_xlim(*frame.time)
    mark(panels, found)
    figure.align_ylabels()
    return figure


def draw_paths(run: Run, recording: Recording, found: Measures, frame: Frame) -> Figure:
    """The paths of base, tool and hands from above, and the panel at some moments."""
    figure, axes = plt.subplots(figsize=(WIDTH, 4.3), layout="constrained")
    motion = Motion.of(recording)
    shown = (motion.time >= found.held.start) & (motion.time < _end(recording, found))
    for name, path, colour, style in (
        ("base", motion.base, GREEN, "-"),
        ("tool", motion.tool, BLUE, "-"),
        ("person's hands", motion.hand, VERMILION, "-"),
    ):
        axes.plot(*path[shown, :2].T, color=colour, linestyle=style, linewidth=1.4, label=name, zorder=4)
        axes.plot(*path[shown, :2][0], "o", color=colour, markersize=5, zorder=5)
        axes.plot(*path[shown, :2][-1], "s", color=colour, markersize=5, zorder=5)
    for name, time, style in _moments(found, _end(recording, found)):
        k = int(np.searchsorted(motion.time, time)) - 1
        outline = _outline(motion, k)
        axes.plot(*outline.T, color=INK, linestyle=style, linewidth=1.0, label=f"panel {name}", zorder=3)
    first, last = motion.base[shown][0], motion.base[shown][-1]
    for x, y, _ in (first, last):
        axes.add_patch(plt.Circle((x, y), _FOOTPRINT, fill=False, color=FAINT, linewidth=0.8, zorder=2))
    axes.set_aspect("equal")
    axes.set_xlim(*frame.ground[0])
    axes.set_ylim(*frame.ground[1])
    axes.set_xlabel("x, away from the robot [m]")
    axes.set_ylabel("y, to its left [m]")
    head(axes, run.title)
    figure.legend(loc="outside lower center", ncols=4, handlelength=2.8, columnspacing=1.4)
    return figure


def draw_heights(run: Run, recording: Recording, found: Measures, frame: Frame) -> Figure:
    """Heights of the panel's ends, and how it is turned, over time."""
    figure, panels = stacked(2, 5.6)
    motion = Motion.of(recording)
    shown = motion.time >= found.held.start - SHOWN_BEFORE
    time = motion.time[shown]
    heights, turns = panels
    for name, values, colour, style in (
        ("robot's end", motion.ends[:, 0, 2], BLUE, "-"),
        ("person's end", motion.ends[:, 1, 2], VERMILION, (0, (4, 1.5))),
        ("lowest corner", motion.lowest, INK, (0, (1.5, 1))),
    ):
        heights.plot(time, values[shown], color=colour, linestyle=style, linewidth=1.5, label=name)
    heights.set_ylabel("height of the panel [m]")
    heights.set_ylim(-0.04, frame.height)
    heights.legend(loc="lower left")
    tool = motion.tool_roll - motion.tool_roll[shown][0]
    for name, values, colour, style in (
        ("panel about its long axis", motion.roll, VERMILION, "-"),
        ("tool about the same", tool, BLUE, (0, (4, 1.5))),
        ("long axis off the horizontal", motion.tilt, INK, (0, (1.5, 1))),
    ):
        turns.plot(time, np.degrees(values[shown]), color=colour, linestyle=style, linewidth=1.5, label=name)
    turns.set_ylabel("turned [°]")
    turns.set_yticks(range(0, 91, 30))
    turns.legend(loc="upper left")
    for axes in panels:
        if np.isfinite(found.held.end):
            axes.axvline(found.held.end, color=INK, linewidth=0.9, zorder=2)
    head(heights, run.title, pad=34)
    turns.set_xlabel("time [s]")
    turns.set_xlim(*frame.time)
    mark(panels, found)
    return figure


def draw_comparison(
    runs: Mapping[str, Run], recordings: Mapping[str, Recording], found: Mapping[str, Measures]
) -> Figure:
    """The runs with the same script: how much of the limits is used, and what the person exerts and does."""
    figure, panels = stacked(3, 7.4)
    load, force, work = panels
    for name, run in runs.items():
        base = name.rpartition("-")[2]
        style = DIFFERENTIAL if base == "differential" else STYLES[run.law]
        look: dict[str, Any] = {"color": COLOURS[run.law], "linestyle": style, "linewidth": 1.3}
        recording, it = recordings[name], found[name]
        end = _end(recording, it)
        wrenches = Wrenches.of(recording, it.held.start, end)
        load.plot(wrenches.time, _largest(wrenches.time, wrenches.load.max(axis=1)), label=run.title, **look)
        motion = Motion.of(recording)
        held = (motion.time >= it.held.start) & (motion.time < end)
        force.plot(motion.time[held], np.linalg.norm(motion.push[held], axis=1), **look)
        work.plot(motion.time[held], guiding_work(motion)[held], **look)
    load.axhline(1.0, **LIMIT_LINE, zorder=8)
    load.set_yscale("log")
    load.set_yticks((0.1, 0.2, 0.5, 1, 2, 5, 10), ("0.1", "0.2", "0.5", "limit", "2", "5", "10"))
    load.minorticks_off()
    load.set_ylim(0.08, 12.0)
    load.set_ylabel("largest share of a limit\non any of the six axes")
    force.set_ylabel("force of the\nperson's hands [N]")
    force.set_ylim(bottom=0.0)
    work.set_ylabel("work of guiding\nso far [J]")
    work.set_xlabel("time [s]")
    work.set_xlim(
        min(it.held.start for it in found.values()) - SHOWN_BEFORE,
        max(_end(recordings[name], it) for name, it in found.items()) + SHOWN_BEFORE,
    )
    mark(panels, next(iter(found.values())))
    figure.legend(loc="outside upper left", ncols=2, handlelength=3.2)
    figure.align_ylabels()
    return figure


def _end(recording: Recording, found: Measures) -> float:
    last = recording.event("end")
    return found.held.end if not found.held.for_good or last is None else last.time


def _moments(found: Measures, end: float) -> list[tuple[str, float, Any]]:
    """When the panel is drawn, and with which line: at the grasp, pulled, to the left, at the release."""
    ends = {one.name: one.end for one in found.followed if np.isfinite(one.end)}
    moments: list[tuple[str, float, Any]] = [("at the grasp", found.held.start, (0, (1, 1)))]
    if "pull" in ends:
        moments.append(("pulled", ends["pull"], (0, (6, 2))))
    if "left" in ends:
        moments.append(("at the left", ends["left"], (0, (4, 1.5, 1, 1.5))))
    return [*moments, ("at the release", end, "-")]


def _outline(motion: Motion, k: int) -> np.ndarray:
    """The panel's outline from above (5, 2) [m] at a sample: the corners of its larger face that is up, or its edge."""
    length, width, thickness = np.array(PANEL_SIZE) / 2.0
    across = 1 if abs(motion.panel_axes[k, 2, 2]) > abs(motion.panel_axes[k, 2, 1]) else 2
    half = width if across == 1 else thickness
    corners = np.array(((-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1))) * (length, half)
    return motion.panel[k, :2] + corners @ motion.panel_axes[k, :2][:, [0, across]].T


def _largest(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    half = max(1, round(WINDOW / 2 / float(np.median(np.diff(time)))))
    padded = np.pad(values, half, mode="edge")
    return np.lib.stride_tricks.sliding_window_view(padded, 2 * half + 1).max(axis=1)


def mark(panels: Sequence[Axes], found: Measures) -> None:
    """Shades the parts in all panels, whose time axis is as it will be, and names them above the first one."""
    first, last = panels[0].get_xlim()
    for part in parts(found.states, found.doings, found.followed, found.states[-1][1]):
        if not part.name or not first <= 0.5 * (part.start + part.end) <= last:
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
