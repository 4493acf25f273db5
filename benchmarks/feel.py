"""What carrying with the robot feels like, law by law: ``python -m benchmarks.feel [--carries N] [--jobs N]``.

The carry of `tandem run carry`, with the base, in simulated time, a few times with other noise. All figures are of the
parts in which the person guides the robot, by the simulation's own account; docs/feel.md says whose definitions they
are.
"""

from __future__ import annotations

import argparse
import copy
import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from multiprocessing import get_context

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.experiment_stack import play_run
from services.experiment.carry import carry_protocol as protocol
from services.experiment.carry.carry import CARRY
from services.experiment.carry.carry_measures import measure
from services.experiment.carry.effort import GUIDING
from services.experiment.carry.excess import Wrenches
from services.experiment.carry.following import SETTLING, Followed
from services.experiment.carry.motion import Motion, spin, turned, turns_about_z
from services.experiment.measure.series import at, rate
from services.experiment.play.recording import Recording
from shared.spatial import Array

WINDOW = 0.3
"""[s] over which a cubic is fitted for speed and jerk: what shakes faster is not counted."""


@dataclass(frozen=True)
class Feel:
    """Of one carry, while the person guides; NaN where there is no such movement.

    Attributes:
        force: mean horizontal force [N] of the hands.
        peak: largest horizontal force [N] of the hands.
        work: of the hands on the panel [J], without the weight that they lift and without what came back.
        robot: work of the robot on the panel [J]: negative, it resists.
        interaction: mean force [N], along the way of a translation, with which hands and robot pull or push against
            each other.
        over: share of the time with any axis over its limit.
        longest: time [s] for which an axis was over its limit without a break.
        wish, hands, tool: log dimensionless jerk of a translation, the mean of all: of what the person wants, of the
            hands, and of the robot's end.
        lag: time [s] by which the robot's end is behind the wish half-way, the mean of all movements.
    """

    force: float
    peak: float
    work: float
    robot: float
    interaction: float
    over: float
    longest: float
    wish: float
    hands: float
    tool: float
    lag: float


FIGURES: dict[str, Callable[[Feel], float]] = {
    "hands' force, mean [N]": lambda one: one.force,
    "hands' force, largest [N]": lambda one: one.peak,
    "hands' work [J]": lambda one: one.work,
    "robot's work [J]": lambda one: one.robot,
    "against each other, mean [N]": lambda one: one.interaction,
    "over a limit [%]": lambda one: 100.0 * one.over,
    "over a limit at a stretch [s]": lambda one: one.longest,
    "smoothness of the wish": lambda one: one.wish,
    "smoothness of the hands": lambda one: one.hands,
    "smoothness of the robot's end": lambda one: one.tool,
    "robot's end behind the wish [s]": lambda one: one.lag,
}


def log_dimensionless_jerk(time: Array, way: Array) -> float:
    """``-ln(T^3 / v_max^2 * integral of |d^2 v/dt^2|^2 dt)`` of a way (n, k) at times (n,) [s]; NaN if nothing moved.

    The measure LDLJ-V of Balasubramanian et al. (2015) of the vector v; larger is smoother.
    """
    step = float(np.median(np.diff(time)))
    even = np.arange(time[0], time[-1], step)
    half = max(2, round(WINDOW / 2.0 / step))
    # A cubic through each window by least squares: its slope and its third derivative in the middle. Before and after
    # the movement all rests.
    path = np.pad(at(even, time, way), ((half, half), (0, 0)), mode="edge")
    fit = np.linalg.pinv(np.vander(step * np.arange(-half, half + 1), 4, increasing=True))
    windows = np.lib.stride_tricks.sliding_window_view(path, 2 * half + 1, axis=0)
    velocity, jerk = windows @ fit[1], 6.0 * windows @ fit[3]
    fastest = float(np.linalg.norm(velocity, axis=1).max())
    lasts = float(time[-1] - time[0])
    total = step * float((jerk**2).sum())
    return -float(np.log(lasts**3 / fastest**2 * total)) if fastest > 0.0 and total > 0.0 else float("nan")


def opposing(one: Array, other: Array) -> Array:
    """The force (n,) [N] with which two work against each other along a line, given what each exerts (n,)."""
    return np.where(one * other < 0.0, np.minimum(np.abs(one), np.abs(other)), 0.0)


def feel(recording: Recording) -> Feel:
    """Takes the figures of one carry.

    Raises:
        ValueError: it did not get so far.
    """
    found, motion = measure(recording), Motion.of(recording)
    wrenches = Wrenches.of(recording, found.held.start, found.held.end)
    lasts, guiding = np.gradient(motion.time), np.isin(motion.doing, GUIDING)
    guiding &= (motion.time >= found.held.start) & (motion.time < found.held.end)
    # What the robot exerts on the panel, in world axes.
    heading = turns_about_z(motion.base[:, 2])
    exerted = -at(motion.time, wrenches.time, wrenches.wrench)
    force, torque = turned(heading, exerted[:, :3]), turned(heading, exerted[:, 3:])
    power = np.sum(force * rate(motion.time, motion.tool), axis=1)
    power += np.sum(torque * spin(motion.time, motion.tool_axes), axis=1)
    # Half of the weight is the robot's to carry, and its work while that rises or falls is nobody's doing.
    power -= at(motion.time, wrenches.time, wrenches.nominal)[:, 2] * rate(motion.time, motion.tool)[:, 2]
    pushes = np.linalg.norm(motion.push[:, :2], axis=1)
    over = (wrenches.load > 1.0).any(axis=1)
    judged = np.interp(wrenches.time, motion.time, guiding) > 0.5
    ways = [_translation(motion, one, force) for one in found.followed if one.way != "roll" and not np.isnan(one.start)]
    interaction, wish, hands, tool = np.mean(ways, axis=0) if ways else [float("nan")] * 4
    return Feel(
        force=float((pushes * lasts)[guiding].sum() / lasts[guiding].sum()),
        peak=found.effort.guiding_force,
        work=found.effort.guiding,
        robot=float((power * lasts)[guiding].sum()),
        interaction=float(interaction),
        over=float(over[judged].mean()),
        longest=_longest(wrenches.time, over & judged),
        wish=float(wish),
        hands=float(hands),
        tool=float(tool),
        lag=float(np.mean([one.lag for one in found.followed])),
    )


def _translation(motion: Motion, one: Followed, force: Array) -> tuple[float, float, float, float]:
    """Mean force against each other [N], and the smoothness of wish, hands and robot's end, of one movement."""
    during = (motion.time >= one.start) & (motion.time < one.end + SETTLING)
    time = motion.sampled[during]
    gone = (motion.wish[during][-1] - motion.wish[during][0])[:2]
    along = gone / np.linalg.norm(gone)
    against = opposing(motion.push[during, :2] @ along, force[during, :2] @ along)
    smooth = [log_dimensionless_jerk(time, path[during]) for path in (motion.wish, motion.hand, motion.tool)]
    return float(against.mean()), smooth[0], smooth[1], smooth[2]


def _longest(time: Array, true: Array) -> float:
    """Longest stretch [s] in which something (n,) holds without a break."""
    edges = np.flatnonzero(np.diff(np.r_[False, true, False]))
    stretches = [float(time[last - 1] - time[first]) for first, last in zip(edges[::2], edges[1::2], strict=True)]
    return max(stretches, default=0.0)


def play(job: tuple[str, int]) -> tuple[str, Feel]:
    """One carry under a law, with the noise of a seed."""
    law, seed = job
    run = copy.deepcopy(protocol.run(law, "omni"))
    run.settings["sim"]["seed"] = seed
    return law, feel(play_run(CARRY, run))


def main(arguments: Sequence[str] | None = None) -> int:
    """Play the carries and print median and range of each figure."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.feel", description=__doc__)
    parser.add_argument("--carries", type=int, default=3, help="under each law, with other noise (default %(default)s)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="processes at a time")
    options = parser.parse_args(arguments)
    jobs = [(law, seed) for law in protocol.LAWS for seed in range(options.carries)]
    results: dict[str, list[Feel]] = {law: [] for law in protocol.LAWS}
    with get_context("spawn").Pool(options.jobs, maxtasksperchild=4) as pool:
        for number, (law, found) in enumerate(pool.imap_unordered(play, jobs), 1):
            results[law].append(found)
            print(f"{number}/{len(jobs)} {law}: {found}", file=sys.stderr, flush=True)
    table = Table(title=f"{options.carries} carries under each law, median (least to largest)")
    for column in ("", *results):
        table.add_column(column, justify="right" if column else "left")
    for name, figure in FIGURES.items():
        table.add_row(name, *(_cell([figure(one) for one in found]) for found in results.values()))
    Console(width=120, markup=False).print(table)
    return 0


def _cell(values: Sequence[float]) -> str:
    return f"{np.median(values):.2f} ({min(values):.2f} to {max(values):.2f})"


if __name__ == "__main__":
    sys.exit(main())
