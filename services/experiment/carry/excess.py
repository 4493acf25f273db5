"""The measured wrench against its limits, and against what the person's and the base's motion allows beyond them."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from services.experiment.carry.allowance import Certified
from services.experiment.carry.carry_protocol import FORCE_LIMIT, TORQUE_LIMIT
from services.experiment.carry.motion import Motion, rotations, turns_about_z
from services.experiment.play.recording import Recording
from shared import topics

AXES = ("fx", "fy", "fz", "tx", "ty", "tz")
FAR_OVER = 1.5  # limits: beyond is far beyond
BEFORE, AFTER = 1.0, 0.3
"""[s] The fastest motion from so long before a sample to so long after it accounts for its excess: an excess dies down
after the motion, and while it builds up the hands push before they move."""
REST_SPEED, REST_TURNING = 0.01, 0.03  # [m/s, rad/s]: what moves no faster rests
ATTITUDE = 0.05  # [rad] by which the tool turns before its stiffness bound is asked for anew
STATED = np.array(FORCE_LIMIT + TORQUE_LIMIT)  # [N, Nm] limits that the task is to ask for
_Z = 2


@dataclass(frozen=True)
class Wrenches:
    """The wrench at every sample of a span of time.

    Attributes:
        time: (n,) [s].
        wrench: (n, 6) [N, Nm] at the tool in base axes.
        nominal: (n, 6) what it carries by agreement; the limits are centred on it.
        limit: (n, 6) [N, Nm].
        error: (n, 6) bound on the wrench's error.
    """

    time: np.ndarray
    wrench: np.ndarray
    nominal: np.ndarray
    limit: np.ndarray
    error: np.ndarray

    @classmethod
    def of(cls, recording: Recording, start: float, end: float) -> Wrenches:
        """What was measured from a time [s] to another.

        Raises:
            KeyError: wrench or target is not in the recording.
            ValueError: a wrench was measured before anybody had said what the limits are.
        """
        key, agreed = topics.WRENCH_EXTERNAL.key, topics.CONTROL_TARGET.key
        time = recording.time(key)
        chosen = (time >= start) & (time < end)
        if chosen.any() and time[chosen][0] < recording.time(agreed)[0]:
            raise ValueError("the panel was held before anybody said with which limits")
        time = time[chosen]
        return cls(
            time=time,
            wrench=np.hstack([recording.series(key, name)[chosen] for name in ("force", "torque")]),
            nominal=recording.newest(agreed, time, "nominal_force", "nominal_torque"),
            limit=recording.newest(agreed, time, "force_limit", "torque_limit"),
            error=recording.series(key, "error_bound")[chosen],
        )

    def at(self, chosen: np.ndarray) -> Wrenches:
        """The wrench at the chosen samples (n,) alone."""
        return Wrenches(*(getattr(self, field.name)[chosen] for field in fields(self)))

    @property
    def load(self) -> np.ndarray:
        """|w - nominal| / limit (n, 6)."""
        return np.abs(self.wrench - self.nominal) / self.limit


@dataclass(frozen=True)
class Asked:
    """Of `control/target`, at every sample of the wrench.

    Attributes:
        off: largest difference of a limit to the stated one [N, Nm].
        lowest, highest: nominal force along z [N].
        other: largest nominal force or torque on any other axis [N, Nm].
    """

    off: float
    lowest: float
    highest: float
    other: float


def asked(wrenches: Wrenches) -> Asked:
    """What was asked for in a span in which the panel was held."""
    carried = wrenches.nominal[:, _Z]
    return Asked(
        off=float(np.abs(wrenches.limit - STATED).max(initial=0.0)),
        lowest=float(carried.min(initial=0.0)),
        highest=float(carried.max(initial=0.0)),
        other=float(np.abs(np.delete(wrenches.nominal, _Z, axis=1)).max(initial=0.0)),
    )


@dataclass(frozen=True)
class Excess:
    """How far and how often the limits were exceeded outside of brakes; shares of the time are 0 to 1.

    Attributes:
        judged: share of the time that no brake upset: in one the arm has to stand, whatever the person does.
        braked_peak: largest |w - nominal| / limit in the rest; 0 if there is none.
        peaks: largest |w - nominal| / limit of each axis (6,).
        over: share of the time with any axis over its limit.
        over_each: share of the time with each axis (6,) over its limit.
        surely_over: share of the time with any axis over its limit by more than the error bound.
        far_over: share of the time with any axis over FAR_OVER limits.
        resting: seconds in which neither the hands nor the base moved.
        resting_peak: the largest (|w - nominal| - error bound) / limit in them; NaN if there were none.
        fastest: largest speed [m/s] and turning rate [rad/s] of the hands relative to the base.
        used: largest share that a sure excess takes of what the motion allows; NaN where nothing is certified.
        allowed: the largest peak / limit of each axis (6,) that the motion accounts for at any time; NaN where
            nothing is certified.
    """

    judged: float
    braked_peak: float
    peaks: tuple[float, ...]
    over: float
    over_each: tuple[float, ...]
    surely_over: float
    far_over: float
    resting: float
    resting_peak: float
    fastest: tuple[float, float]
    used: float
    allowed: tuple[float, ...]


def excess(wrenches: Wrenches, quiet: np.ndarray, motion: Motion, certified: Certified | None) -> Excess:
    """Takes the figures of a span in which the panel was held; `quiet` (n,) are the samples that no brake upset."""
    upset, wrenches = wrenches.at(~quiet), wrenches.at(quiet)
    fastest = _fastest(motion, wrenches.time)
    load, sure = wrenches.load, wrenches.load - wrenches.error / wrenches.limit
    linear, angular = (np.linalg.norm(fastest[:, part], axis=1) for part in (slice(3), slice(3, 6)))
    rests = (linear <= REST_SPEED) & (angular <= REST_TURNING)
    used, allowed = float("nan"), np.full(6, np.nan)
    if certified is not None:
        room = certified.excess(fastest, nearest_attitude(motion, wrenches.time, certified)) / wrenches.limit
        used = float(np.max((sure - 1.0) / np.maximum(room, 1e-9), initial=0.0))
        allowed = 1.0 + room.max(axis=0, initial=0.0)
    step = float(np.median(np.diff(wrenches.time))) if len(wrenches.time) > 1 else 0.0
    return Excess(
        judged=float(np.mean(quiet)) if len(quiet) else 0.0,
        braked_peak=float(upset.load.max(initial=0.0)),
        peaks=tuple(load.max(axis=0, initial=0.0).tolist()),
        over=_share(load > 1.0),
        over_each=tuple(np.mean(load > 1.0, axis=0).tolist()) if len(load) else (0.0,) * 6,
        surely_over=_share(sure > 1.0),
        far_over=_share(load > FAR_OVER),
        resting=step * int(rests.sum()),
        resting_peak=float(sure[rests].max()) if rests.any() else float("nan"),
        fastest=(float(linear.max(initial=0.0)), float(angular.max(initial=0.0))),
        used=used,
        allowed=tuple(allowed.tolist()),
    )


def attitudes(recording: Recording, start: float, end: float) -> np.ndarray:
    """Attitudes (k, 4) of the tool in base that are ATTITUDE apart, in the order in which it took them."""
    key = topics.STATE_EE.key
    time = recording.time(key)
    quaternions = recording.series(key, "orientation")[(time >= start) & (time < end)]
    chosen: list[np.ndarray] = []
    for one in quaternions:
        if not chosen or 2.0 * np.arccos(min(1.0, abs(float(one @ chosen[-1])))) > ATTITUDE:
            chosen.append(one)
    return np.array(chosen)


def nearest_attitude(motion: Motion, time: np.ndarray, certified: Certified) -> np.ndarray:
    """For each time (n,) the index of the certified attitude that the tool is nearest to."""
    back = turns_about_z(motion.base[:, 2]).transpose(0, 2, 1)
    tool = (back @ motion.tool_axes).reshape(-1, 9)
    known = rotations(certified.attitudes).reshape(-1, 9)
    # trace(R' S) grows as the angle between two attitudes shrinks.
    nearest = np.argmax(tool @ known.T, axis=1)
    return nearest[np.clip(np.searchsorted(motion.time, time), 0, len(motion.time) - 1)]


def _fastest(motion: Motion, time: np.ndarray) -> np.ndarray:
    """Largest |u| (n, 6) of the hands' twist in base axes, component by component, around each time (n,)."""
    twist = np.abs(motion.twist_in_base)
    first = np.searchsorted(motion.time, time - BEFORE)
    last = np.searchsorted(motion.time, time + AFTER, side="right")
    return np.array([twist[a : max(b, a + 1)].max(axis=0) for a, b in zip(first, last, strict=True)])


def _share(over: np.ndarray) -> float:
    return float(np.mean(over.any(axis=1))) if len(over) else 0.0
