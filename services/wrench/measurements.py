"""Measurements that were asked for and take a while: a tare, and the poses of an identification."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from services.wrench.averaging import Average, AveragingWindow, NotStill
from services.wrench.compensation import Compensation
from services.wrench.identification import IdentifiedPayload, NotExciting, identify
from shared.parameters import Refused
from shared.requests import AddPose, PoseAdded, Solved, Tare, Tared
from shared.schema.records import Record
from shared.service import Reply
from shared.spatial import Array

MOST_POSES = 100  # of one identification


class Measurements:
    """One measurement at a time, answered when its window is full or as soon as it is spoilt.

    Args:
        adopt: told what to subtract from now on when a tare is complete, before the tare is answered; returns the age
            [s] of the zero that this replaces.
    """

    def __init__(self, adopt: Callable[[Compensation], float]) -> None:
        self._adopt = adopt
        self._window: AveragingWindow | None = None
        self._taring = False
        self._reply: Reply | None = None
        self._poses: list[Average] | None = None

    def begin(self, request: Tare | AddPose, noise_bound: Array, reply: Reply) -> None:
        """Start a tare, or a pose of the identification; ``reply`` is called in a later step.

        Raises:
            Refused: if one is running, or no identification was started.
        """
        taring = isinstance(request, Tare)
        if self._window is not None:
            raise Refused("a measurement is running: ask again when it has been answered")
        if not taring and self._poses is None:
            raise Refused('no identification was started: ask {"action": "start"} first')
        if not taring and self._poses is not None and len(self._poses) >= MOST_POSES:
            raise Refused(f"{MOST_POSES} poses were added already: solve, or start anew")
        self._window = AveragingWindow(request.duration, noise_bound)
        self._taring, self._reply = taring, reply

    def add(self, raw: Array, rotation: Array, dt: float, compensation: Compensation) -> None:
        """Take in a reading, which may complete what was asked for.

        Args:
            raw: force and torque (6,), sensor axes.
            rotation: sensor in upright axes (3, 3).
            dt: time [s] since the last reading.
            compensation: in force now.
        """
        if self._window is None or not self._window.add(raw, rotation, dt):
            return
        try:
            average = self._window.average()
        except NotStill as problem:
            self.abort(str(problem))
            return
        if self._taring:
            tared = compensation.tared(average.mean, average.mean_error, average.noise, average.rotation)
            replaced_age = self._adopt(tared)
            self._finish(Tared(tared.bias[:3], tared.bias[3:], average.samples, average.std, replaced_age))
            return
        assert self._poses is not None
        self._poses.append(average)
        self._finish(PoseAdded(len(self._poses), average.samples, average.std))

    def abort(self, reason: str) -> None:
        """Refuse the running measurement, if there is one; poses that were added stay."""
        if self._window is not None:
            self._finish(Refused(reason))

    def restart(self, start: bool) -> None:
        """Forget all poses, and begin an identification if ``start``."""
        if not self._taring:
            self.abort("the identification was ended")
        self._poses = [] if start else None

    def solve(self) -> IdentifiedPayload:
        """The payload from the poses that were added; they are forgotten then.

        Raises:
            Refused: if no identification was started, a pose is being measured, or the poses do not determine it.
        """
        if self._poses is None:
            raise Refused('no identification was started: ask {"action": "start"} first')
        if self._window is not None:
            raise Refused("a measurement is running: ask again when it has been answered")
        try:
            result = identify(self._poses)
        except NotExciting as problem:
            raise Refused(str(problem)) from None
        self._poses = None
        return result

    def _finish(self, answer: Record | Refused) -> None:
        reply, self._reply, self._window, self._taring = self._reply, None, None, False
        assert reply is not None
        reply(answer)


def described(result: IdentifiedPayload, file: str) -> Solved:
    """An identified payload as the query answers it, with the file that it was written to."""
    sigma = (result.sigma_mass, result.sigma_com, result.sigma_force_bias, result.sigma_torque_bias)
    return Solved(
        result.mass,
        result.com,
        result.force_bias,
        result.torque_bias,
        np.hstack(sigma),
        result.residual_rms,
        result.condition,
        result.poses,
        file,
    )
