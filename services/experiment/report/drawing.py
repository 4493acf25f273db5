"""How the figures of all experiments look, and how they are written."""

from __future__ import annotations

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.figure import Figure

# Okabe and Ito's palette: told apart with any colour vision; line styles carry the same information in grey.
BLUE, SKY, GREEN, ORANGE, VERMILION = "#0072B2", "#56B4E9", "#009E73", "#E69F00", "#D55E00"
LIMIT_COLOUR = "#B00020"
INK, FAINT = "#222222", "#9A9A9A"

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


def save(figure: Figure, stem: Path) -> tuple[Path, Path]:
    """Writes the figure as STEM.svg and STEM.png and closes it; returns both paths."""
    paths = stem.with_suffix(".svg"), stem.with_suffix(".png")
    figure.savefig(paths[0], metadata={"Date": None})
    figure.savefig(paths[1], dpi=200)
    plt.close(figure)
    return paths
