"""Figures of the load experiment: load and tool height over time, one run alone and all runs together."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from services.experiment.measures import Measures
from services.experiment.protocol import RUNS, Run
from services.experiment.recording import Recording
from shared import topics

# Okabe and Ito's palette: told apart with any colour vision; line styles carry the same information in grey.
COLOURS = dict(
    zip((run.name for run in RUNS), ("#D55E00", "#56B4E9", "#0072B2", "#009E73", "#7F7F7F"), strict=True)
)
STYLES = dict(
    zip((run.name for run in RUNS), ("-", (0, (4, 1.5)), "-", (0, (1.5, 1)), (0, (6, 2, 1, 2))), strict=True)
)
LIMIT_COLOUR = "#B00020"
INK, FAINT = "#222222", "#9A9A9A"
WIDTH = 7.4  # [in]

plt.rcParams.update(
    {
        "font.family": "DejaVu Sans",
        "font.size": 9,
        "axes.edgecolor": FAINT,
        "axes.labelcolor": INK,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.grid": True,
        "grid.color": "#E4E4E4",
        "grid.linewidth": 0.6,
        "xtick.color": INK,
        "ytick.color": INK,
        "legend.frameon": False,
        "svg.hashsalt": "tandem",
    }
)


def draw_run(run: Run, recording: Recording, found: Measures) -> Figure:
    """Load -force z [N] with its limit, and tool z [m], of one run."""
    figure, (load, height) = _panels(2, 4.6)
    colour = COLOURS.get(run.name, "#0072B2")
    _draw_load(load, recording, colour)
    _limit(load, recording)
    time, z = _height(recording)
    height.plot(time, z, color=colour, linewidth=1.4)
    height.axhline(found.hold_height, color=FAINT, linewidth=0.8, linestyle=":")
    _events(load, height, recording, found)
    load.set_title(run.title, loc="left", fontsize=10, fontweight="bold")
    _finish((load, height), recording)
    return figure


def draw_comparison(runs: Mapping[str, Run], recordings: Mapping[str, Recording]) -> Figure:
    """Load and tool height of all runs over one time axis."""
    figure, (load, height) = _panels(2, 5.4)
    for name, run in runs.items():
        recording = recordings[name]
        time, force = _smooth(*_load(recording))
        line = {"color": COLOURS.get(name, INK), "linestyle": STYLES.get(name, "-"), "linewidth": 1.4}
        load.plot(time, force, **line)
        height.plot(*_height(recording), label=run.title, **line)
    first = next(iter(recordings.values()))
    _limit(load, first)
    _events(load, height, first, None)
    handles, labels = height.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper left", ncols=2, handlelength=3.2)
    _finish((load, height), first)
    return figure


def draw_lowering(
    runs: Mapping[str, Run], recordings: Mapping[str, Recording], found: Mapping[str, Measures]
) -> Figure:
    """The moments after the heavier bag, on a time axis that starts with it: how each law lowers and lands."""
    figure, (load, height) = _panels(2, 4.6)
    longest = max((m.lowering_time for m in found.values() if np.isfinite(m.lowering_time)), default=5.0)
    for name, run in runs.items():
        recording = recordings[name]
        heavy = recording.event("heavy")
        zero = heavy.time if heavy else 0.0
        line = {"color": COLOURS.get(name, INK), "linestyle": STYLES.get(name, "-"), "linewidth": 1.4}
        time, force = _load(recording)
        load.plot(time - zero, force, **line | {"linewidth": 1.0})
        time, z = _height(recording)
        height.plot(time - zero, z, label=run.title, **line)
        if np.isfinite(found[name].landing):
            at = found[name].landing - zero
            height.plot(at, np.interp(at, time - zero, z), "o", color=line["color"], markersize=5, zorder=5)
    _limit(load, next(iter(recordings.values())))
    handles, labels = height.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper left", ncols=2, handlelength=3.2)
    height.set_xlim(-0.5, longest + 2.5)
    _labels(load, height)
    height.set_xlabel("time since the heavier bag [s]   (dot: the bag touches the ground)")
    return figure


def save(figure: Figure, stem: Path) -> tuple[Path, Path]:
    """Writes the figure as STEM.svg and STEM.png and closes it; returns both paths."""
    paths = stem.with_suffix(".svg"), stem.with_suffix(".png")
    figure.savefig(paths[0], metadata={"Date": None})
    figure.savefig(paths[1], dpi=200)
    plt.close(figure)
    return paths


def _panels(rows: int, height: float) -> tuple[Figure, np.ndarray]:
    return plt.subplots(rows, 1, sharex=True, figsize=(WIDTH, height), layout="constrained")


def _load(recording: Recording) -> tuple[np.ndarray, np.ndarray]:
    key = topics.WRENCH_EXTERNAL.key
    return recording.time(key), -recording.series(key, "force")[:, 2]


def _height(recording: Recording) -> tuple[np.ndarray, np.ndarray]:
    key = topics.STATE_EE.key
    return recording.time(key), recording.series(key, "position")[:, 2]


def _smooth(time: np.ndarray, values: np.ndarray, window: float = 0.1) -> tuple[np.ndarray, np.ndarray]:
    """Moving mean over `window` [s], so that five noisy lines can be told apart; the figures of one run show all."""
    count = max(1, round(window / float(np.median(np.diff(time)))))
    return time[count - 1 :], np.convolve(values, np.ones(count) / count, "valid")


def _draw_load(axes: Axes, recording: Recording, colour: str) -> None:
    time, force = _load(recording)
    axes.plot(time, force, color=colour, linewidth=0.5, alpha=0.45)
    axes.plot(*_smooth(time, force), color=colour, linewidth=1.4)


def _limit(axes: Axes, recording: Recording) -> None:
    limit = recording.meta["force_limit"][2]
    axes.axhline(limit, color=LIMIT_COLOUR, linewidth=1.0, linestyle=(0, (5, 2)))
    axes.annotate(
        f"limit {limit:.0f} N",
        (1.0, limit),
        xycoords=("axes fraction", "data"),
        xytext=(-2, 3),
        textcoords="offset points",
        ha="right",
        color=LIMIT_COLOUR,
        fontsize=8,
    )


def _events(load: Axes, height: Axes, recording: Recording, found: Measures | None) -> None:
    marks = [
        (event.time, event.detail) for event in recording.events if event.name in ("light", "heavy", "unload")
    ]
    if found is not None and np.isfinite(found.landing):
        marks.append((found.landing, "on the ground"))
    for time, text in marks:
        for axes in (load, height):
            axes.axvline(time, color=FAINT, linewidth=0.8)
        height.annotate(
            text,
            (time, 0.0),
            xycoords=("data", "axes fraction"),
            xytext=(3, 4),
            textcoords="offset points",
            rotation=90,
            va="bottom",
            fontsize=8,
            color="#555555",
        )


def _labels(load: Axes, height: Axes) -> None:
    load.set_ylabel("load on the tool, −f$_z$ [N]")
    height.set_ylabel("tool height z [m]")


def _finish(panels: tuple[Axes, Axes], recording: Recording) -> None:
    load, height = panels
    _labels(load, height)
    height.set_xlabel("time [s]")
    height.set_xlim(0.0, float(recording.time(topics.STATE_EE.key)[-1]))
