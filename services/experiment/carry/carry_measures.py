"""Figures taken from one run's recording of the carry: what became of the panel, of the limits, and of the person.

What the panel and the person's hands did is the simulation's own account of them (`sim/world`); everything else comes
from topics that a real robot publishes too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from services.experiment.carry.allowance import Certified
from services.experiment.carry.carry_protocol import GUIDANCE
from services.experiment.carry.effort import Effort, effort
from services.experiment.carry.excess import Asked, Excess, Wrenches, asked, attitudes, excess
from services.experiment.carry.following import Followed, followed
from services.experiment.carry.grip import Held, Release, fastest_descent, held, release, unsupported
from services.experiment.carry.motion import Motion
from services.experiment.measure.brakes import Brake, brakes, undisturbed
from services.experiment.measure.disturbance import longest_gap, unhealthy
from services.experiment.play.recording import Recording
from shared import topics


@dataclass(frozen=True)
class Measures:
    """One run in figures. Times [s] on the experiment's clock, angles [rad].

    Attributes:
        states: of the task, in order, each with the time at which it was first heard.
        doings: what the person was about, in order, each with the time at which it began.
        reason: what the task said of its last state.
        held: from when to when the gripper held the panel.
        let_go_in: state of the task when the gripper let go; "" if it never did.
        tilt: largest angle of the panel's long axis to the horizontal while it was held.
        descent: fastest that an end of the panel went down [m/s], from the grasp to the end.
        unsupported: seconds in which it was in the air and the gripper did not hold it.
        asked: which limits were in force while it was held.
        brakes: in that time.
        excess: of the wrench over its limits in the rest of that time.
        active: share of that time in which some limit shaped the motion.
        followed: what became of each movement of the person.
        effort: of the person, from the grasp to the end.
        release: the panel when it was let go.
        longest_gap, unhealthy: how well the machine kept time, from the grasp on.
    """

    states: tuple[tuple[str, float], ...]
    doings: tuple[tuple[str, float], ...]
    reason: str
    held: Held
    let_go_in: str
    tilt: float
    descent: float
    unsupported: float
    asked: Asked
    brakes: tuple[Brake, ...]
    excess: Excess
    active: float
    followed: tuple[Followed, ...]
    effort: Effort
    release: Release
    longest_gap: float
    unhealthy: float


def measure(recording: Recording) -> Measures:
    """Takes the figures of one run.

    Raises:
        KeyError: a topic or a field is not in the recording.
        ValueError: the run did not finish, or the panel was never held; the text says so.
    """
    name = str(recording.meta.get("name"))
    if recording.event("end") is None:
        raise ValueError(f"run {name}: the recording has no event 'end': the run did not finish")
    motion = Motion.of(recording)
    states, reason = task_states(recording)
    span = held(recording, dict(reversed(states)).get("carrying", float("inf")))
    if not np.isfinite(span.start):
        raise ValueError(f"run {name}: the gripper never held the panel; the task was {states[-1][0]}: {reason}")
    end = float(motion.time[-1]) if span.for_good else span.end
    during = (motion.time >= span.start) & (motion.time < end)
    wrenches = Wrenches.of(recording, span.start, end)
    braked = tuple(brake for brake in brakes(recording) if brake.end >= span.start and brake.start < end)
    allowance = None
    if recording.meta["law"] == "certified":
        allowance = Certified.of(
            recording.meta["settings"]["controller"],
            wrenches.limit.min(axis=0),
            wrenches.error.max(axis=0),
            attitudes(recording, span.start, end),
        )
    return Measures(
        states=states,
        doings=changes(motion.time, motion.doing),
        reason=reason,
        held=span,
        let_go_in="" if span.for_good else [state for state, time in states if time <= span.end][-1],
        tilt=float(np.abs(motion.tilt[during]).max(initial=0.0)),
        descent=fastest_descent(motion, span.start),
        unsupported=unsupported(motion, span),
        asked=asked(wrenches),
        brakes=braked,
        excess=excess(wrenches, undisturbed(wrenches.time, braked), motion, allowance),
        active=_active(recording, span.start, end),
        followed=followed(motion, GUIDANCE[name.rpartition("-")[2]]),
        effort=effort(motion, span.start, float(motion.time[-1])),
        release=release(recording, motion, span),
        longest_gap=longest_gap(recording),
        unhealthy=unhealthy(recording, span.start),
    )


def task_states(recording: Recording) -> tuple[tuple[tuple[str, float], ...], str]:
    """The task's states since the start, each with the time [s] when it was first heard, and the last one's reason.

    Raises:
        KeyError: nothing at all was heard of it.
        ValueError: nothing was heard after the start.
    """
    key = topics.TASK_STATUS.key
    since = recording.time(key) >= 0.0
    states = changes(recording.time(key)[since], recording.series(key, "state")[since])
    if not states:
        raise ValueError("nothing was heard of the task after the start")
    return states, str(recording.series(key, "reason")[-1])


def changes(time: np.ndarray, values: np.ndarray) -> tuple[tuple[str, float], ...]:
    """Every value of a series of words, "" left out, where it begins [s]."""
    begins = np.flatnonzero(np.r_[True, values[1:] != values[:-1]][: len(values)])
    return tuple((str(values[k]), float(time[k])) for k in begins if values[k])


def _active(recording: Recording, start: float, end: float) -> float:
    key = topics.CONTROL_STATUS.key
    time = recording.time(key)
    active = recording.series(key, "active")[(time >= start) & (time < end)]
    return float(np.mean((active != 0).any(axis=1))) if len(active) else 0.0
