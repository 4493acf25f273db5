"""How the figures of all experiments look, and how they are written."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.lib.stride_tricks import sliding_window_view

# Okabe and Ito's palette: told apart with any colour vision; line styles carry the same information in grey.
BLUE, SKY, GREEN, ORANGE, VERMILION = "#0072B2", "#56B4E9", "#009E73", "#E69F00", "#D55E00"
LIMIT_COLOUR = "#B00020"
INK, FAINT = "#222222", "#9A9A9A"
LIMIT_LINE: dict[str, Any] = {"color": LIMIT_COLOUR, "linewidth": 1.0, "linestyle": (0, (5, 2))}
WIDTH = 7.4  # [in] of a figure
WINDOW = 0.3  # [s] of a mean, a range or a largest value that is drawn

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


def stacked(count: int, height: float) -> tuple[Figure, list[Axes]]:
    """A figure of a height [in] with panels below each other on one time axis."""
    figure, axes = plt.subplots(count, 1, sharex=True, figsize=(WIDTH, height), layout="constrained")
    return figure, list(axes)


def head(axes: Axes, title: str, pad: float | None = None) -> None:
    """The figure's title, above a panel by so many points."""
    axes.set_title(title, loc="left", fontsize=10, fontweight="bold", pad=pad)


def windows(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Centres (m,) [s] and contents (m, n) of the windows of WINDOW that slide over a series (k,)."""
    count = max(2, round(WINDOW / float(np.median(np.diff(time)))))
    return sliding_window_view(time, count).mean(axis=1), sliding_window_view(values, count)


def save(figure: Figure, stem: Path) -> tuple[Path, Path]:
    """Writes the figure as STEM.svg and STEM.png and closes it; returns both paths."""
    paths = stem.with_suffix(".svg"), stem.with_suffix(".png")
    figure.savefig(paths[0], metadata={"Date": None})
    figure.savefig(paths[1], dpi=200)
    plt.close(figure)
    return paths
