"""Measurements that were asked for and take a while: a tare, and the poses of an identification."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from services.wrench.averaging import Average, AveragingWindow, NotStill
from services.wrench.identification import IdentifiedPayload, NotExciting, NoWeight, identify
from services.wrench.plausibility import refusal
from services.wrench.suspects import suspects, unexplained, unmoved
from shared.parameters import Refused
from shared.requests import AddPose, PoseAdded, Solved, Tare, Tared
from shared.schema.records import Record
from shared.service import Reply
from shared.spatial import Array

MOST_POSES = 100  # of one identification


class Measurements:
    """One measurement at a time, answered when its window is full or as soon as it is spoilt.

    Args:
        tared: told the average of a tare when it is complete; adopts it and gives the answer, or refuses.
    """

    def __init__(self, tared: Callable[[Average, Tare], Tared]) -> None:
        self._tared = tared
        self._window: AveragingWindow | None = None
        self._tare: Tare | None = None
        self._reply: Reply | None = None
        self._poses: list[Average] | None = None

    def begin(self, request: Tare | AddPose, window: AveragingWindow, reply: Reply) -> None:
        """Start a tare, or a pose of the identification; ``reply`` is called in a later step.

        Raises:
            Refused: if one is running, or no identification was started.
        """
        tare = request if isinstance(request, Tare) else None
        if self._window is not None:
            raise Refused("a measurement is running: ask again when it has been answered")
        if tare is None and self._poses is None:
            raise Refused('no identification was started: ask {"action": "start"} first')
        if tare is None and self._poses is not None and len(self._poses) >= MOST_POSES:
            raise Refused(f"{MOST_POSES} poses were added already: solve, or start anew")
        self._window, self._tare, self._reply = window, tare, reply

    def add(self, raw: Array, rotation: Array, dt: float) -> None:
        """Take in a reading, which may complete what was asked for.

        Args:
            raw: force and torque (6,), sensor axes.
            rotation: sensor in upright axes (3, 3).
            dt: time [s] since the last reading.
        """
        if self._window is None or not self._window.add(raw, rotation, dt):
            return
        try:
            average = self._window.average()
        except NotStill as problem:
            self.abort(str(problem))
            return
        if self._tare is not None:
            try:
                self._finish(self._tared(average, self._tare))
            except Refused as refusal:
                self._finish(refusal)
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
        if self._tare is None:
            self.abort("the identification was ended")
        self._poses = [] if start else None

    def solve(
        self, force: bool, tilt: float, judge: Callable[[IdentifiedPayload], str]
    ) -> tuple[IdentifiedPayload, str]:
        """The payload from the poses that were added, and what is implausible about it; the poses are forgotten then.

        Args:
            force: take it although it is implausible.
            tilt: largest error of the attitude [rad].
            judge: says why a payload is not possible, empty if it is.

        Raises:
            Refused: if no identification was started, a pose is being measured, the poses do not determine a payload or
                the payload is implausible.
        """
        if self._poses is None:
            raise Refused('no identification was started: ask {"action": "start"} first')
        if self._window is not None:
            raise Refused("a measurement is running: ask again when it has been answered")
        try:
            result = identify(self._poses)
        except NoWeight as problem:
            raise Refused(f"{problem}: {suspects(self._poses, tilt)}") from None
        except NotExciting as problem:
            raise Refused(str(problem)) from None
        doubt = unmoved(self._poses) or unexplained(result, self._poses, tilt) or judge(result)
        if doubt and not force:
            raise refusal(doubt)
        self._poses = None
        return result, doubt

    def _finish(self, answer: Record | Refused) -> None:
        reply, self._reply, self._window, self._tare = self._reply, None, None, None
        assert reply is not None
        reply(answer)


def described(result: IdentifiedPayload, file: str, warning: str) -> Solved:
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
        warning,
    )
