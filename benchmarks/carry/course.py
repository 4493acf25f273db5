"""The carry's course with the person of a case, who tells the robot what it waits for.

The person says `tandem task release` when the robot does not let go of a panel on the ground, once more if it still
does not, and `tandem resume` and `tandem task start` when it holds because a fault was latched.
"""

from __future__ import annotations

import re

from benchmarks.carry.cases import Case
from services.experiment.carry.carry_course import CarrySequence
from services.experiment.play.course import Ask
from services.experiment.play.observation import Observation
from services.experiment.play.recording import Event
from shared import topics

PATIENCE = 12.0
"""Time [s] for which the person waits with the panel on the ground before saying so."""


LOOKS, ENDS = 1.0, 1.0
"""Time [s] until the person says `resume`, and from then on until `start`: less than the course waits for a task that
holds."""
MOST_WORDS = 4  # that the person says in all
MOST_RELEASES = 2
"""The second one opens the gripper at once."""
ALONE = 6.0
"""Time [s] for which the robot has to hold what the person has let go of."""
NOTE_EVERY = 1.0  # [s]


class SweepCourse(CarrySequence):
    """Plays a case.

    Attributes:
        told: what the person had to say to the robot, in order.
        resumes: whether the person says `tandem resume` now.
    """

    def __init__(self, case: Case) -> None:
        super().__init__(case.run, case.script)
        self._case = case
        self._alone_since: float | None = None
        self._waiting_since: float | None = None
        self._said = ""
        self._said_at = 0.0
        self._held_since: float | None = None
        self.told: list[str] = []
        self.resumes = False

    def meanwhile(self, now: float, seen: Observation) -> list[Ask]:
        """What the person says to a robot that waits for a word."""
        self._note(now, seen.reason)
        if self._case.ends_held:
            self._watch(now, seen)
        elif asks := self._resume(now, seen):
            return asks
        waits = seen.doing == "wait" and seen.task in ("carrying", "releasing")
        if not waits:
            self._waiting_since = None
        elif self._waiting_since is None:
            self._waiting_since = now
        elif now - self._waiting_since > PATIENCE and self.told.count("release") < MOST_RELEASES:
            self._waiting_since = now
            return self._tell(now, seen, "release")
        return []

    def _watch(self, now: float, seen: Observation) -> None:
        """What becomes of a panel whose other end the person has let go of."""
        if seen.task not in ("carrying", "holding") or seen.doing:
            self._alone_since = None
        elif self._alone_since is None:
            self._alone_since = now
        elif now - self._alone_since > ALONE:
            self.done = True

    def _resume(self, now: float, seen: Observation) -> list[Ask]:
        """What is said when the robot holds for something that only a person may end: `resume`, and then `start`."""
        self.resumes = False
        if seen.task != "holding" or "tandem resume" not in seen.reason or len(self.told) > MOST_WORDS:
            self._held_since = None
        elif self._held_since is None:
            self._held_since = now
        elif now - self._held_since > LOOKS + ENDS:
            self._held_since = None
            return self._tell(now, seen, "start")
        elif now - self._held_since > LOOKS:
            self.resumes = True
        return []

    def _tell(self, now: float, seen: Observation, word: str) -> list[Ask]:
        self.told.append(word)
        self.events.append(Event(now, f"person: {word}", seen.reason))
        return self.ask(now, Ask(topics.TASK_COMMAND, {"command": word}))

    def _note(self, now: float, reason: str) -> None:
        """Keep what the task says, once a second at most; a number that changes is nothing new."""
        words = re.sub(r"[-\d.]+", "", reason)
        if words != self._said and now - self._said_at > NOTE_EVERY:
            self._said, self._said_at = words, now
            self.events.append(Event(now, "says", reason))
