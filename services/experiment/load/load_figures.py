"""Figures of the load experiment: load and tool height over time, one run alone and all runs together."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from services.experiment.load.load_measures import Measures
from services.experiment.load.load_protocol import RUNS
from services.experiment.measure.brakes import SETTLING
from services.experiment.play.course import Run
from services.experiment.play.recording import Recording
from services.experiment.report.drawing import FAINT, INK, LIMIT_COLOUR, LIMIT_LINE, head, stacked, windows
from shared import topics

# Okabe and Ito's palette: told apart with any colour vision; line styles carry the same information in grey.
COLOURS = dict(zip((run.name for run in RUNS), ("#D55E00", "#56B4E9", "#0072B2", "#009E73", "#7F7F7F"), strict=True))
STYLES = dict(zip((run.name for run in RUNS), ("-", (0, (4, 1.5)), "-", (0, (1.5, 1)), (0, (6, 2, 1, 2))), strict=True))
HEIGHT = 5.0  # [in]
LOAD = (-3.0, 37.0)  # [N] that is shown at least
HEADROOM = 0.06  # of the range of heights


@dataclass(frozen=True)
class Frame:
    """The scales of all runs' figures, so that they can be held against each other: load [N], height [m], end [s]."""

    load: tuple[float, float]
    height: tuple[float, float]
    end: float

    @classmethod
    def of(cls, recordings: Iterable[Recording]) -> Frame:
        """Wide enough for all recordings, and for `LOAD` at least."""
        found = list(recordings)
        # Before the clock starts there is nothing to see.
        forces = [force[time >= 0.0] for time, force in map(_load, found)]
        heights = [height[time >= 0.0] for time, height in map(_height, found)]
        low, high = min(map(np.min, heights)), max(map(np.max, heights))
        return cls(
            (min(LOAD[0], *map(np.min, forces)), max(LOAD[1], *map(np.max, forces))),
            (low - HEADROOM * (high - low), high + HEADROOM * (high - low)),
            max(float(_height(recording)[0][-1]) for recording in found),
        )


def draw_run(run: Run, recording: Recording, found: Measures, frame: Frame) -> Figure:
    """Load -force z [N] with its limit, and tool z [m], of one run; grey is what a brake upset on the way down."""
    figure, (load, height) = stacked(2, HEIGHT)
    colour = COLOURS.get(run.name, "#0072B2")
    time, force = _load(recording)
    load.plot(time, force, color=colour, linewidth=0.5, alpha=0.4)
    load.plot(*_mean(time, force), color=colour, linewidth=1.6)
    height.plot(*_height(recording), color=colour, linewidth=1.6)
    height.axhline(found.hold_height, color=FAINT, linewidth=0.8, linestyle=":")
    for brake in found.brakes:
        load.axvspan(brake.start, brake.end + SETTLING, color=FAINT, alpha=0.25, linewidth=0)
    _mark((load, height), recording, found)
    head(load, run.title)
    _finish((load, height), frame)
    return figure


def draw_comparison(runs: Mapping[str, Run], recordings: Mapping[str, Recording]) -> Figure:
    """Load (mean, and pale the range within WINDOW) and tool height of all runs over one time axis."""
    figure, (load, height) = stacked(2, HEIGHT)
    for name, run in runs.items():
        colour, style = COLOURS.get(name, INK), STYLES.get(name, "-")
        time, force = _load(recordings[name])
        load.fill_between(*_range(time, force), color=colour, alpha=0.16, linewidth=0)
        load.plot(*_mean(time, force), color=colour, linestyle=style, linewidth=1.4)
        height.plot(*_height(recordings[name]), label=run.title, color=colour, linestyle=style, linewidth=1.4)
    _mark((load, height), next(iter(recordings.values())), None)
    _legend(figure, height)
    _finish((load, height), Frame.of(recordings.values()))
    return figure


def draw_lowering(
    runs: Mapping[str, Run], recordings: Mapping[str, Recording], found: Mapping[str, Measures]
) -> Figure:
    """The moments after the heavier bag, on a time axis that starts with it: how each law lowers and lands."""
    figure, (load, height) = stacked(2, HEIGHT)
    longest = max((m.lowering_time for m in found.values() if np.isfinite(m.lowering_time)), default=5.0)
    for layer, (name, run) in enumerate(runs.items(), start=2):
        recording = recordings[name]
        heavy = recording.event("heavy")
        zero = heavy.time if heavy else 0.0
        colour, style = COLOURS.get(name, INK), STYLES.get(name, "-")
        time, force = _load(recording)
        load.plot(time - zero, force, color=colour, linewidth=0.9, alpha=0.85, zorder=layer)
        time, z = _height(recording)
        height.plot(time - zero, z, label=run.title, color=colour, linestyle=style, linewidth=1.4)
        if np.isfinite(found[name].landing):
            at = found[name].landing - zero
            height.plot(at, np.interp(at, time - zero, z), "o", color=colour, markersize=5, zorder=9)
    _limit(load, next(iter(recordings.values())))
    _legend(figure, height)
    _labels(load, height)
    height.set_xlim(-0.5, longest + 2.0)
    height.set_xlabel("time since the heavier bag [s]")
    return figure


def _load(recording: Recording) -> tuple[np.ndarray, np.ndarray]:
    key = topics.WRENCH_EXTERNAL.key
    return recording.time(key), -recording.series(key, "force")[:, 2]


def _height(recording: Recording) -> tuple[np.ndarray, np.ndarray]:
    key = topics.STATE_EE.key
    return recording.time(key), recording.series(key, "position")[:, 2]


def _mean(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    centres, contents = windows(time, values)
    return centres, contents.mean(axis=1)


def _range(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    centres, contents = windows(time, values)
    return centres, contents.min(axis=1), contents.max(axis=1)


def _limit(axes: Axes, recording: Recording) -> None:
    limit = recording.meta["force_limit"][2]
    axes.axhline(limit, **LIMIT_LINE, zorder=8)
    axes.annotate(
        f"limit {limit:.0f} N",
        (1.0, limit),
        xycoords=("axes fraction", "data"),
        xytext=(4, 0),
        textcoords="offset points",
        va="center",
        color=LIMIT_COLOUR,
        fontsize=8,
        annotation_clip=False,
    )


def _mark(panels: Sequence[Axes], recording: Recording, found: Measures | None) -> None:
    """Lines through both panels; events are named in the upper one, the landing in the lower one, where it is seen."""
    marks = [
        (event.time, event.detail, panels[0], 1.0)
        for event in recording.events
        if event.name in ("light", "heavy", "unload")
    ]
    if found is not None and np.isfinite(found.landing) and found.lowering_time > 0.5:
        marks.append((found.landing, "on the ground", panels[1], 0.92))
    for time, text, panel, top in marks:
        for axes in panels:
            axes.axvline(time, color=FAINT, linewidth=0.8, zorder=1)
        panel.annotate(
            text,
            (time, top),
            xycoords=("data", "axes fraction"),
            xytext=(3, -2),
            textcoords="offset points",
            va="top",
            fontsize=8,
            color="#555555",
        )
    _limit(panels[0], recording)


def _legend(figure: Figure, axes: Axes) -> None:
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper left", ncols=2, handlelength=3.2)


def _labels(load: Axes, height: Axes) -> None:
    load.set_ylabel("load on the tool, −f$_z$ [N]")
    load.set_ylim(*LOAD)
    height.set_ylabel("tool height z [m]")


def _finish(panels: Sequence[Axes], frame: Frame) -> None:
    load, height = panels
    _labels(load, height)
    load.set_ylim(*frame.load)
    height.set_ylim(*frame.height)
    height.set_xlabel("time [s]")
    height.set_xlim(0.0, frame.end)
