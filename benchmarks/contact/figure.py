"""One figure of the contact benchmark: how far each law goes over the limit, at rest, moving, and at a wall."""

from __future__ import annotations

from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot as plt
from matplotlib.axes import Axes

from benchmarks.contact import scripted
from benchmarks.contact.laws import make_law
from benchmarks.contact.measure import OVER, Row
from benchmarks.contact.simulate import simulate

STYLE = {
    "paper": ("#c0392b", "paper"),
    "stiffness": ("#999999", "stiffness, 40 N/m"),
    "certified": ("#1f618d", "certified, strict"),
    "certified-rounded": ("#27ae60", "certified, rounded (0.8)"),
}
_SHOWN = (0.3, 30.0)


def draw(rows: list[Row], path: Path) -> None:
    """Writes the figure to ``path``."""
    plt.rcParams.update({"font.size": 10, "axes.spines.top": False, "axes.spines.right": False})
    figure, (rest, moving, wall) = plt.subplots(1, 3, figsize=(15.0, 4.8), layout="constrained")
    _peaks(rest, [row for row in rows if row.at_rest], "Environment at rest")
    _peaks(moving, [row for row in rows if not row.at_rest], "Environment moving at 0.1 and 0.2 m/s")
    rest.set_ylabel("share of the cases with a higher peak")
    _wall(wall)
    handles, labels = wall.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(STYLE), frameon=False)
    figure.savefig(path, dpi=150)
    plt.close(figure)


def _peaks(axes: Axes, rows: list[Row], title: str) -> None:
    for law, (colour, _) in STYLE.items():
        peaks = np.sort([row.result.peak for row in rows if row.law == law])
        if len(peaks):
            share = 1.0 - np.arange(1, len(peaks) + 1) / len(peaks)
            axes.step(np.clip(peaks, *_SHOWN), share, where="post", color=colour, lw=2)
    cases = len({(row.job.group, row.job.number) for row in rows})
    axes.axvline(1.0, color="black", lw=1, ls="--")
    axes.set(xscale="log", xlim=_SHOWN, ylim=(0.0, 1.0), title=f"{title}\n{cases} cases, all laws on the same ones")
    axes.set_xticks((0.5, 1, 2, 5, 10, 20), ("0.5", "1", "2", "5", "10", "20"))
    axes.minorticks_off()
    axes.set_xlabel("highest force or torque, in limits")
    over = [(law, np.mean([row.over for row in rows if row.law == law])) for law in STYLE if rows]
    for line, (law, share) in enumerate(over):
        text = f"{STYLE[law][1]}: {share:.0%} over" if share else f"{STYLE[law][1]}: none over {OVER:g}"
        axes.text(0.98, 0.96 - 0.07 * line, text, color=STYLE[law][0], transform=axes.transAxes, ha="right", va="top")


def _wall(axes: Axes) -> None:
    case = scripted.wall("slide", scripted.WALL_STIFFNESS)
    for law, (colour, label) in STYLE.items():
        trace = simulate(make_law(law, case), keep_trace=True).trace
        assert trace is not None
        axes.plot(trace.times, -trace.ratio[:, 0], color=colour, lw=1.5 if law.startswith("cert") else 0.8, label=label)
    axes.axhline(1.0, color="black", lw=1, ls="--")
    axes.axvline(scripted.WALL_PRESS, color="black", lw=0.6, ls=":")
    axes.text(scripted.WALL_PRESS + 0.1, 0.03, "slides 200 mm", transform=axes.get_xaxis_transform(), fontsize=9)
    axes.set(title="Pressing a wall of 2000 N/m, 100 Hz,\nthen sliding along it", xlabel="time [s]", xlim=(0.0, 9.0))
    axes.set_ylabel("force, in limits")
    axes.set_ylim(bottom=0.0)
