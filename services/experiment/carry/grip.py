"""Whether the panel was held all the time, let go of when the ground carried it, and stayed where it was put."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from services.experiment.carry.carry_protocol import PANEL_MASS
from services.experiment.carry.motion import Motion
from services.experiment.play.recording import Recording
from shared import topics
from shared.spatial import GRAVITY

ON_GROUND = 0.005  # [m]: a corner lower than this touches the ground
LIFTED = 0.02  # [m] by which the panel's centre has to rise to count as lifted off its supports
AVERAGED = 0.1  # [s] of the force at the moment of release, as the task itself takes it


@dataclass(frozen=True)
class Held:
    """From when to when the gripper held the panel [s]; NaN if it never did, or never let go."""

    start: float
    end: float

    @property
    def for_good(self) -> bool:
        """Whether it never let go."""
        return not np.isfinite(self.end)


@dataclass(frozen=True)
class Release:
    """The panel at the moment when the gripper did not hold it any more, and what became of it; NaN if it never came.

    Attributes:
        height: of its lowest corner above the ground [m].
        ground: force [N] by which the ground carried it: its weight less what hands and gripper carried.
        carried: force [N] by which the gripper still carried it.
        roll, tilt: [rad] off standing upright on its edge, off the horizontal.
        moved: how far [m] its centre has gone from there at the end, when the person has let go too.
        leaning: how far [rad] it is off standing upright on its edge at the end.
    """

    height: float
    ground: float
    carried: float
    roll: float
    tilt: float
    moved: float
    leaning: float


def held(recording: Recording, carrying: float) -> Held:
    """When the gripper held the panel: from its grasp until it did not hold any more.

    Args:
        recording: of the run.
        carrying: when the task began to carry [s]: closing, the fingers may touch and lose the panel until then.
    """
    key = topics.STATE_GRIPPER.key
    time, holding = recording.time(key), recording.series(key, "holding").astype(bool)
    lost = np.flatnonzero(~holding & (time < carrying))
    first = int(lost[-1]) + 1 if len(lost) else 0
    if not holding[first:].any():
        return Held(float("nan"), float("nan"))
    first += int(np.argmax(holding[first:]))
    loose = np.flatnonzero(~holding[first:])
    return Held(float(time[first]), float(time[first + loose[0]]) if len(loose) else float("nan"))


def fastest_descent(motion: Motion, start: float) -> float:
    """The fastest that either end of the panel went down [m/s] from a time [s] on, from one sample to the next."""
    since = motion.time >= start
    heights, time = motion.ends[since, :, 2], motion.sampled[since]
    return float(np.max(-np.diff(heights, axis=0) / np.diff(time)[:, None], initial=0.0))


def unsupported(motion: Motion, span: Held) -> float:
    """Seconds in which a panel that was lifted was neither in the gripper nor on the ground."""
    if not np.isfinite(span.end):
        return 0.0
    start = float(np.interp(span.start, motion.time, motion.panel[:, 2]))
    risen = np.maximum.accumulate(np.where(motion.time >= span.start, motion.panel[:, 2], start))
    loose = (motion.time >= span.end) & (risen > start + LIFTED) & (motion.lowest > ON_GROUND)
    return float(np.gradient(motion.time)[loose].sum())


def release(recording: Recording, motion: Motion, span: Held) -> Release:
    """The panel when the gripper opened, and at the end."""
    if span.for_good:
        return Release(*[float("nan")] * 7)
    # The last sample in which it was held, not the first in which the open gripper may have moved it.
    k = max(int(np.searchsorted(motion.time, span.end)) - 1, 0)
    key = topics.WRENCH_EXTERNAL.key
    time = recording.time(key)
    recent = (time > span.end - AVERAGED) & (time <= span.end)
    carried = -float(recording.series(key, "force")[recent, 2].mean()) if recent.any() else float("nan")
    upright = np.sign(motion.roll) * np.pi / 2
    return Release(
        height=float(motion.lowest[k]),
        ground=PANEL_MASS * GRAVITY - float(motion.push[k, 2]) - carried,
        carried=carried,
        roll=float(abs(motion.roll[k] - upright[k])),
        tilt=float(abs(motion.tilt[k])),
        moved=float(np.linalg.norm(motion.panel[-1] - motion.panel[k])),
        leaning=float(abs(motion.roll[-1] - upright[-1])),
    )
