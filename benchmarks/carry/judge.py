"""What became of a carry, by ground truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.carry.witness import PERIOD

AXES = ("fx", "fy", "fz", "tx", "ty", "tz")
ABOVE_GROUND = 0.01
"""Height [m] of an end of the panel above the ground from which on it is not standing on it."""
FALLEN = 0.9
"""Least sine of how far the width of a panel that stands on its edge points up."""
CARRYING = ("carrying", "releasing")


@dataclass(frozen=True)
class Verdict:
    """One carry, judged.

    Attributes:
        end: state of the task at the end.
        reason: of that state.
        time: from start to `done` [s]; None if that was not reached.
        lost: the gripper lost the panel without having been told to open.
        fell: nobody held the panel, and it was not on the ground.
        gap: height [m] of the panel's near end above the ground when the gripper opened; None if it did not.
        carried: force [N] that the robot carried then.
        told: what a person had to say to the task, in order.
        share: of the time while it carried in which the force on an axis was above its limit, per axis.
        peak: largest force over limit, per axis.
        tilt: largest pitch [rad] of the panel while both held it.
        strain: of the person's arms while he held it: mean force [N] and torque [Nm].
        stands: at the end the panel stands on its edge.
        held: at the end the gripper holds it.
        ends_held: that is what was to be, because the person let go of his end in the middle.
        warned: the robot had said that the panel would be torn out of its fingers if that was done.
        trouble: why the experiment itself could not go on.
    """

    end: str
    reason: str
    time: float | None
    lost: bool = False
    fell: bool = False
    gap: float | None = None
    carried: float = 0.0
    told: tuple[str, ...] = ()
    share: tuple[float, ...] = (0.0,) * 6
    peak: tuple[float, ...] = (0.0,) * 6
    tilt: float = 0.0
    strain: tuple[float, float] = (0.0, 0.0)
    stands: bool = False
    held: bool = False
    ends_held: bool = False
    warned: bool = False
    trouble: str = ""

    @property
    def torn(self) -> bool:
        """Whether a panel heavier than the gripper holds was torn out of it because the person let go all the same."""
        return self.lost and self.ends_held and self.warned

    @property
    def dropped(self) -> bool:
        """Whether the panel fell, or the gripper lost it, and the person had not been told so before he let go."""
        return (self.lost or self.fell) and not self.torn

    @property
    def early(self) -> bool:
        """Whether the gripper opened although the ground did not carry the panel."""
        return self.gap is not None and self.gap > ABOVE_GROUND

    @property
    def completed(self) -> bool:
        """Whether the panel was set down on purpose and the robot has gone back."""
        return self.end == "done" and self.gap is not None and not self.dropped and not self.early

    @property
    def safe(self) -> bool:
        """Whether the robot has kept its end of a panel that it could not go on with, and says why it waits."""
        return self.ends_held and self.held and self.gap is None and not self.dropped and bool(self.reason)

    @property
    def as_it_should(self) -> bool:
        """Whether this is an end that nobody has to explain."""
        return self.completed or self.safe or self.torn

    @property
    def word(self) -> str:
        """The verdict in one word."""
        if self.dropped:
            return "DROPPED"
        if self.early:
            return "EARLY"
        if self.torn:
            return "torn out as announced"
        if self.safe:
            return "held safely"
        return "completed" if self.completed else "NOT COMPLETED"


def judge(
    seen: dict[str, np.ndarray],
    limits: np.ndarray,
    end: str,
    reason: str,
    told: Sequence[str],
    trouble: str = "",
    ends_held: bool = False,
    warned: bool = False,
) -> Verdict:
    """The verdict on what the witness saw.

    Args:
        seen: by the names of ``witness.COLUMNS``.
        limits: of force and torque (6,) [N, Nm].
        end: state of the task.
        reason: of that state.
        told: what a person had to say to it.
        trouble: of the experiment.
        ends_held: whether the panel is to be held in the end, and not set down.
        warned: whether the robot said that it could not hold it alone.
    """
    state, time = seen["state"], seen["time"]
    gripped, opening, held = seen["gripped"], seen["opening"], seen["held"]
    carrying = np.isin(state, CARRYING)
    begun = int(np.argmax(carrying)) if carrying.any() else len(time)
    after = np.arange(len(time)) >= begun
    opened = after & opening
    let_go = int(np.argmax(opened)) if opened.any() else None
    # The contact in a grip that was just closed on nothing yet, or is opening, is not what is judged here.
    still_closed = after & ~opening
    free = after & ~gripped & ~held & ~seen["supported"] & (seen["lowest"] > ABOVE_GROUND)
    share, peak = np.zeros(6), np.zeros(6)
    loaded = carrying & ~opening & gripped
    if loaded.any():
        wrench = seen["wrench"][loaded].copy()
        wrench[:, 2] -= seen["nominal"][loaded]
        ratio = np.abs(wrench) / limits
        share, peak = (ratio > 1.0).mean(axis=0), ratio.max(axis=0)
    together = loaded & held & ~seen["supported"]
    started = int(np.argmax(state == "calibrating"))
    done = np.flatnonzero(state == "done")
    return Verdict(
        end=end,
        reason=reason,
        time=float(time[done[0]] - time[started]) if len(done) else None,
        lost=bool((still_closed & ~gripped).sum() * PERIOD > 0.05),
        fell=bool(free.sum() * PERIOD > 0.05),
        gap=None if let_go is None else float(seen["near"][let_go]),
        carried=0.0 if let_go is None else -float(seen["wrench"][let_go, 2]),
        told=tuple(told),
        share=tuple(share.tolist()),
        peak=tuple(peak.tolist()),
        tilt=float(np.abs(seen["pitch"][together]).max()) if together.any() else 0.0,
        strain=tuple(seen["strain"][held].mean(axis=0).tolist()) if held.any() else (0.0, 0.0),
        stands=bool(seen["upright"][-1] > FALLEN),
        held=bool(gripped[-1]),
        ends_held=ends_held,
        warned=warned,
        trouble=trouble,
    )
