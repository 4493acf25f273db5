"""The carry's course with the person of a case, who says `tandem task release` when the robot does not let go."""

from __future__ import annotations

import re

from benchmarks.carry.cases import Case
from services.experiment.carry.sequence import CarrySequence
from services.experiment.course import Ask
from services.experiment.recording import Event
from services.experiment.seen import Seen
from shared import topics

PATIENCE = 12.0
"""Time [s] for which he waits with the panel on the ground before he says so."""


NOTE_EVERY = 1.0  # [s]


class SweepCourse(CarrySequence):
    """Plays a case.

    Attributes:
        told: whether the person had to say that the robot is to let go.
    """

    def __init__(self, case: Case) -> None:
        super().__init__(case.run)
        self._script = case.script
        self._waiting_since: float | None = None
        self._said = ""
        self._said_at = 0.0
        self.told = False

    def _place(self, now: float, _seen: Seen) -> list[Ask]:
        return self.ask(now, Ask(topics.SIM_COMMAND, {"command": "hand", "script": self._script}))

    def _play(self, now: float, seen: Seen) -> list[Ask]:
        self._note(now, seen.reason)
        waits = seen.doing == "wait" and seen.task == "carrying"
        if not waits:
            self._waiting_since = None
        elif self._waiting_since is None:
            self._waiting_since = now
        elif now - self._waiting_since > PATIENCE and not self.told:
            self.told = True
            self.events.append(Event(now, "person: release", seen.reason))
            return self.ask(now, Ask(topics.TASK_COMMAND, {"command": "release"}))
        return super()._play(now, seen)

    def accepted(self, ask: Ask, sent: float, now: float) -> None:
        """One step further; saying `release` is none."""
        if ask.request.get("command") != "release":
            super().accepted(ask, sent, now)

    def _note(self, now: float, reason: str) -> None:
        """Keep what the task says, once a second at most; a number that changes is nothing new."""
        words = re.sub(r"[-\d.]+", "", reason)
        if words != self._said and now - self._said_at > NOTE_EVERY:
            self._said, self._said_at = words, now
            self.events.append(Event(now, "says", reason))
