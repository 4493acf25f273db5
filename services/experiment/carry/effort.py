"""What a carry costs the person: forces, torques and work of the hands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from services.experiment.carry.carry_protocol import PANEL_MASS
from services.experiment.carry.motion import Motion, spin
from services.experiment.measure.series import rate
from shared.spatial import GRAVITY

HARD_TORQUE = 9.0  # [Nm] of both hands that nobody wants to exert for long
GUIDING = ("move", "turn")  # what the person is about while guiding the robot


@dataclass(frozen=True)
class Effort:
    """Work is positive when the person does it.

    Attributes:
        force, torque: largest [N], [Nm] of the hands.
        guiding_force: largest horizontal force [N] while guiding.
        hard: seconds with more than HARD_TORQUE.
        work: what the hands did in all [J]; they also let the panel down, so it may be negative.
        lifting: the part of it that half of the panel's weight took [J].
        guiding: work done on the panel while guiding [J], without that weight and without what came back.
    """

    force: float
    torque: float
    guiding_force: float
    hard: float
    work: float
    lifting: float
    guiding: float


def effort(motion: Motion, start: float, end: float) -> Effort:
    """What it cost from a time [s] to another."""
    during = (motion.time >= start) & (motion.time < end)
    if during.sum() < 2:
        return Effort(*[float("nan")] * 7)
    power, weight = _powers(motion)
    guiding = during & np.isin(motion.doing, GUIDING)
    lasts = np.gradient(motion.time)
    forces, torques = (np.linalg.norm(values, axis=1) for values in (motion.push, motion.twist))
    return Effort(
        force=float(forces[during].max()),
        torque=float(torques[during].max()),
        guiding_force=float(np.linalg.norm(motion.push[guiding, :2], axis=1).max(initial=0.0)),
        hard=float(lasts[during & (torques > HARD_TORQUE)].sum()),
        work=float((power * lasts)[during].sum()),
        lifting=float((weight * lasts)[during].sum()),
        guiding=float((np.maximum(power - weight, 0.0) * lasts)[guiding].sum()),
    )


def guiding_work(motion: Motion) -> np.ndarray:
    """`Effort.guiding` as it grows (n,) [J]."""
    power, weight = _powers(motion)
    spent = np.where(np.isin(motion.doing, GUIDING), np.maximum(power - weight, 0.0), 0.0)
    return np.cumsum(spent * np.gradient(motion.time))


def _powers(motion: Motion) -> tuple[np.ndarray, np.ndarray]:
    """Power (n,) [W] of the hands on the panel, and the part of it that half of the weight takes."""
    velocity = rate(motion.time, motion.hand)
    turning = spin(motion.time, motion.panel_axes)
    power = np.sum(motion.push * velocity, axis=1) + np.sum(motion.twist * turning, axis=1)
    return power, 0.5 * PANEL_MASS * GRAVITY * velocity[:, 2]
