"""The course of an experiment: phases that wait for a condition with a deadline, and requests whose answers decide.

Pure: it is told the time and what was heard last, and answers with the requests to send. It runs alike against real
processes and in simulated time.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from services.experiment.play.observation import Seen
from services.experiment.play.recording import Event
from services.experiment.run import Run
from shared import topics
from shared.topics import Query

TARE_DURATION = 1.0  # [s] averaged
TARE_AGAIN = 8  # times, when it is refused, or was taken where it does not hold
ANSWER_WITHIN = 5.0  # [s] for the answer to a request, beyond what it takes by itself


class Failed(RuntimeError):
    """The experiment cannot go on; the text says what was awaited, what was seen and what to do."""


@dataclass(frozen=True)
class Ask:
    """A request to send; its answer comes back through `Course.answered`."""

    query: Query
    request: dict[str, Any]
    duration: float = 0.0


class Course(ABC):
    """Plays one run on what is seen. Call `step` about ten times a second until `done`.

    Attributes:
        run: configuration that the stack must have.
        phase: what it does now, in words.
        start: time [s] at which the protocol's clock started, or None.
        events: what happened, in the caller's time.
        done: the run is complete.
    """

    def __init__(self, run: Run, phase: str) -> None:
        self.run = run
        self.phase = phase
        self.start: float | None = None
        self.events: list[Event] = []
        self.done = False
        self._since: float | None = None
        self._pending: Ask | None = None
        self._answer: dict[str, Any] | None = None
        self._tares = 0

    @property
    @abstractmethod
    def phases(self) -> Mapping[str, Callable[[float, Seen], list[Ask]]]:
        """What to do in each phase, given the time [s] and what is seen."""

    def step(self, now: float, seen: Seen) -> list[Ask]:
        """One step at time `now` [s, any origin].

        Raises:
            Failed: an awaited condition did not come true in time, or a request was refused.
        """
        if self._since is None:
            self._since = now
        if self._pending is not None:
            self._await_answer(self._pending, now)
            return []
        return self.phases[self.phase](now, seen)

    def answered(self, answer: dict[str, Any]) -> None:
        """Takes the reply to the last `Ask` (a map with `ok`)."""
        self._answer = answer

    def elapsed(self, now: float) -> float | None:
        """Time [s] on the protocol's clock, None before it starts."""
        return None if self.start is None else now - self.start

    @abstractmethod
    def accepted(self, ask: Ask, sent: float, now: float) -> None:
        """A request that was sent at a time [s] was granted."""

    def refused(self, ask: Ask, reason: str, now: float) -> None:
        """A request was not granted. A tare may be disturbed for a moment: the phase begins anew and asks again.

        Raises:
            Failed: for anything else, or too often.
        """
        if ask.query is not topics.WRENCH_TARE or not self.may_tare_again():
            raise Failed(f"{ask.query.key} was refused: {reason}")
        self.enter(self.phase, now)

    def tare(self, now: float) -> list[Ask]:
        """Asks for a tare."""
        return self.ask(now, Ask(topics.WRENCH_TARE, {"duration": TARE_DURATION}, TARE_DURATION))

    def may_tare_again(self) -> bool:
        """Counts a tare that was of no use, and says whether another one may be tried."""
        self._tares += 1
        return self._tares <= TARE_AGAIN

    def ask(self, now: float, ask: Ask) -> list[Ask]:
        """Sends a request; nothing else is done until it is answered."""
        self._pending, self._answer, self._since = ask, None, now
        return [ask]

    def enter(self, phase: str, now: float) -> None:
        """Goes on with another phase, or with the same one anew."""
        self.phase, self._since = phase, now

    def give_up(self, now: float, after: float, why: str) -> None:
        """Fails if the phase, or the last request, was begun more than so long [s] ago.

        Raises:
            Failed: with the reason.
        """
        if self._since is not None and now - self._since > after:
            raise Failed(f"gave up {self.phase} after {after:.0f} s: {why}")

    def _await_answer(self, ask: Ask, now: float) -> None:
        if self._answer is None:
            patience = ask.duration + ANSWER_WITHIN
            self.give_up(now, patience, f"no answer on {ask.query.key}. Is {ask.query.server} running?")
            return
        self._pending = None
        if self._answer.get("ok"):
            self.accepted(ask, now if self._since is None else self._since, now)
        else:
            self.refused(ask, str(self._answer.get("error", "no reason given")), now)
