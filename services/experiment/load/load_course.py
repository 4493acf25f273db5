"""The course of the load experiment: which step follows which, what each waits for and when it gives up."""

from __future__ import annotations

import numpy as np

from services.experiment.load import load_protocol as protocol
from services.experiment.load.load_protocol import mass, unambiguous
from services.experiment.play.course import STANDING, STILL, STILL_WITHIN, Ask, Course, Failed, Run
from services.experiment.play.observation import Observation
from services.experiment.play.recording import Event
from shared import topics

STILL_FOR = 1.0  # [s]
AT_POSE = 0.02  # [m]: near enough to start the clock, ten seconds before the first bag
BACK_AT_POSE = 0.005  # [m] from where the first bag was hung: near enough to end early


class LoadSequence(Course):
    """Tares, takes up the pose, then plays the loads."""

    def __init__(self, run: Run) -> None:
        super().__init__(run, {STANDING: self._stand, "taking up the pose": self._take_up, "playing": self._play})
        self._steady_since: float | None = None
        self._played = 0
        self._rest: np.ndarray | None = None

    def _stand(self, now: float, seen: Observation) -> list[Ask]:
        return self.tare_when(self._steady(now, seen, float("inf")), now, seen)

    def _take_up(self, now: float, seen: Observation) -> list[Ask]:
        if not self._steady(now, seen, AT_POSE):
            away = 1e3 * _distance(seen)
            self.give_up(now, STILL_WITHIN, f"the tool is {away:.0f} mm from the pose to hold. {seen.trouble}")
            return []
        if unambiguous(seen.error_bound) > protocol.HEAVY:
            if self.may_tare_again():
                return self.tare(now)
            raise Failed(
                f"the error bound of force z is {seen.error_bound:.2f} N: the heavier bag of {protocol.HEAVY:g} N "
                f"is not clearly over the limit ({unambiguous(seen.error_bound):.1f} N needed): lower sim.ft_noise"
            )
        self.start = now
        self.events.append(Event(now, "start", f"error bound of force z {seen.error_bound:.2f} N"))
        self.enter("playing", now)
        return []

    def _play(self, now: float, seen: Observation) -> list[Ask]:
        assert self.start is not None
        elapsed = now - self.start
        if self._played < len(_LOADS):
            at, _, weight = _LOADS[self._played]
            if elapsed >= at - 1e-6:
                self._rest = seen.position if self._played == 0 else self._rest
                return self.ask(now, Ask(topics.SIM_COMMAND, {"command": "load", "mass": mass(weight)}))
        elif elapsed >= protocol.END_AT or self._steady(now, seen, BACK_AT_POSE, self._rest):
            self.events.append(Event(now, "end"))
            self.done = True
        return []

    def accepted(self, ask: Ask, sent: float, now: float) -> None:
        """The tare is done, or another load hangs."""
        if ask.query is topics.WRENCH_TARE:
            self.events.append(Event(sent, "tare"))
            self.enter("taking up the pose", now)
        else:
            _, name, weight = _LOADS[self._played]
            self.events.append(Event(sent, name, f"{weight:g} N" if weight else "taken off"))
            self._played += 1
            self._steady_since = None

    def enter(self, phase: str, now: float) -> None:
        """Goes on with another phase; stillness counts anew."""
        super().enter(phase, now)
        self._steady_since = None

    def _steady(self, now: float, seen: Observation, within: float, place: np.ndarray | None = None) -> bool:
        """Whether the tool has been still and within a distance [m] of a place, the pose to hold, for STILL_FOR."""
        if seen.speed > STILL or (within < float("inf") and _distance(seen, place) > within):
            self._steady_since = None
            return False
        if self._steady_since is None:
            self._steady_since = now
        return now - self._steady_since >= STILL_FOR


_LOADS = (
    (protocol.LIGHT_AT, "light", protocol.LIGHT),
    (protocol.HEAVY_AT, "heavy", protocol.HEAVY),
    (protocol.UNLOAD_AT, "unload", 0.0),
)


def _distance(seen: Observation, place: np.ndarray | None = None) -> float:
    if seen.position is None:
        return float("inf")
    return float(np.linalg.norm(seen.position - (np.array(protocol.HOLD[:3]) if place is None else place)))
