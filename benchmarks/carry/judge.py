"""What became of a carry, by ground truth.

A panel that was torn out of the fingers is a drop like any other; that the person had been warned is told beside it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.carry.witness import PERIOD

ABOVE_GROUND = 0.01
"""Height [m] of an end of the panel above the ground from which on it is not standing on it."""
FALLEN = 0.9
"""Least sine of how far the width of a panel that stands on its edge points up."""
ENOUGH = 0.99  # share of the carries that have to end as they should
CARRYING = ("carrying", "releasing")


@dataclass(frozen=True)
class Verdict:
    """One carry, judged.

    Attributes:
        end: state of the task at the end.
        reason: of that state.
        time: from start to `done` [s]; None if that was not reached.
        lost: the gripper lost the panel without having been told to open.
        torn: it lost it after the person had let go of the far end for good, although the task had warned before that.
        fell: nobody held the panel, and it was not on the ground.
        gap: height [m] of the panel's near end above the ground when the gripper opened; None if it did not.
        carried: force [N] that the robot carried then.
        told: what a person had to say to the task, in order.
        share: of the time while it carried in which the force on an axis was above its limit, per axis.
        peak: largest force over limit, per axis.
        tilt: largest pitch [rad] of the panel while both held it.
        strain: spring part of the person's hands while they held it, without damping and the weight that they lift:
            mean force [N] and torque [Nm].
        stands: at the end the panel stands on its edge.
        held: at the end the gripper holds it.
        ends_held: that is what was to be, because the person let go of the far end in the middle.
        trouble: why the experiment itself could not go on.
    """

    end: str
    reason: str
    time: float | None
    lost: bool = False
    torn: bool = False
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
    trouble: str = ""

    @property
    def dropped(self) -> bool:
        """Whether the panel fell, or the gripper lost it, torn out or not."""
        return self.lost or self.fell

    @property
    def early(self) -> bool:
        """Whether the gripper opened although the ground did not carry the panel."""
        return self.gap is not None and self.gap > ABOVE_GROUND

    @property
    def completed(self) -> bool:
        """Whether the panel was set down on purpose, the robot has gone back, and the panel stands where it was put."""
        return self._set_down and self.stands

    @property
    def _set_down(self) -> bool:
        return self.end == "done" and self.gap is not None and not self.dropped and not self.early

    @property
    def safe(self) -> bool:
        """Whether the robot has kept its end of a panel that it could not go on with, and says why it waits."""
        return self.ends_held and self.held and self.gap is None and not self.dropped and bool(self.reason)

    @property
    def as_it_should(self) -> bool:
        """Whether this is an end that nobody has to explain."""
        return self.completed or self.safe

    @property
    def word(self) -> str:
        """The verdict in a word or two."""
        if self.dropped:
            return "DROPPED, torn out" if self.torn else "DROPPED"
        if self.early:
            return "EARLY"
        if self.safe:
            return "held safely"
        if self._set_down:
            return "completed" if self.stands else "FELL OVER"
        return "NOT COMPLETED"


def good_enough(verdicts: Sequence[Verdict]) -> bool:
    """Whether no panel was dropped or let go of early, and at least 99 % ended as they should."""
    bad = any(verdict.dropped or verdict.early for verdict in verdicts)
    return not bad and sum(verdict.as_it_should for verdict in verdicts) >= ENOUGH * len(verdicts)


def judge(
    seen: dict[str, np.ndarray],
    limits: np.ndarray,
    end: str,
    reason: str,
    told: Sequence[str],
    trouble: str = "",
    ends_held: bool = False,
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
    """
    state, time = seen["state"], seen["time"]
    gripped, opening, held = seen["gripped"], seen["opening"], seen["held"]
    carrying = np.isin(state, CARRYING)
    begun = int(np.argmax(carrying)) if carrying.any() else len(time)
    after = np.arange(len(time)) >= begun
    opened = after & opening
    let_go = int(np.argmax(opened)) if opened.any() else None
    # The contact in a grip that was just closed on nothing yet, or is opening, is not what is judged here.
    loss = after & ~opening & ~gripped
    lost = bool(loss.sum() * PERIOD > 0.05)
    let_go_for_good = int(np.flatnonzero(held)[-1]) + 1 if held.any() else len(time)
    warned = bool(seen["warned"][:let_go_for_good].any())
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
        lost=lost,
        torn=lost and ends_held and warned and int(np.argmax(loss)) >= let_go_for_good,
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
        trouble=trouble,
    )
