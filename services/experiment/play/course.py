"""The course of a run: phases that wait for a condition with a deadline, and requests whose answers decide.

Pure: it is told the time and what was heard last, and answers with the requests to send. It runs alike against real
processes and in simulated time.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from services.experiment.play.observation import Observation
from services.experiment.play.recording import Event
from shared import topics
from shared.topics import Query

TARE_DURATION = 1.0  # [s] averaged
TARE_AGAIN = 15  # times, when it is refused, or was taken where it does not hold
ANSWER_WITHIN = 5.0  # [s] for the answer to a request, beyond what it takes by itself
STACK_WITHIN = 30.0  # [s] for the stack to be ready for the run
STILL_WITHIN = 60.0  # [s] for the tool to stand still, or to reach a pose
STILL = 0.005  # [m/s]: a slower tool counts as still
WAITING, STANDING = "waiting for the robot", "standing still before the tare"
"""The phases that every course begins with."""


@dataclass(frozen=True)
class Run:
    """One configuration of the stack under which an experiment is played.

    Attributes:
        name: of the run and of its folder.
        title: for people.
        law: of the controller.
        rate: of the force-torque sensor [Hz].
        settings: the parameters that differ from the services' defaults: service -> parameter -> value.
        further: services that it needs besides those of every stack.
    """

    name: str
    title: str
    law: str
    rate: float
    settings: dict[str, dict[str, Any]] = field(default_factory=dict)
    further: tuple[str, ...] = ()


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

    Args:
        run: configuration that the stack must have.
        phases: what to do in each phase after `WAITING`, given the time [s] and what is seen.

    Attributes:
        run: that is played.
        phase: what it does now, in words.
        start: time [s] at which the protocol's clock started, or None.
        events: what happened, in the caller's time.
        done: the run is complete.
    """

    def __init__(self, run: Run, phases: Mapping[str, Callable[[float, Observation], list[Ask]]]) -> None:
        self.run = run
        self._phases = phases
        self.phase = WAITING
        self.start: float | None = None
        self.events: list[Event] = []
        self.done = False
        self._since: float | None = None
        self._pending: Ask | None = None
        self._answer: dict[str, Any] | None = None
        self._tares = 0

    def step(self, now: float, seen: Observation) -> list[Ask]:
        """One step at time `now` [s, any origin].

        Raises:
            Failed: an awaited condition did not come true in time, or a request was refused.
        """
        if self._since is None:
            self._since = now
        if self._pending is not None:
            self._await_answer(self._pending, now)
            return []
        return self._wait(now, seen) if self.phase == WAITING else self._phases[self.phase](now, seen)

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
        """A request was not granted. A tare may be disturbed for a moment, as while a stack starts on a busy machine:
        the first one waits for a valid wrench again, a later one begins its phase anew, and asks again.

        Raises:
            Failed: for anything else, or too often.
        """
        if ask.query is not topics.WRENCH_TARE or not self.may_tare_again():
            raise Failed(f"{ask.query.key} was refused: {reason}")
        self.enter(WAITING if self.phase == STANDING else self.phase, now)

    def tare(self, now: float) -> list[Ask]:
        """Asks for a tare."""
        return self.ask(now, Ask(topics.WRENCH_TARE, {"duration": TARE_DURATION}, TARE_DURATION))

    def tare_when(self, still: bool, now: float, seen: Observation) -> list[Ask]:
        """Asks for a tare once the tool is still enough.

        Raises:
            Failed: it is not within `STILL_WITHIN`.
        """
        if still:
            return self.tare(now)
        moves = f"the tool still moves at {1e3 * seen.speed:.0f} mm/s. {seen.trouble}"
        self.give_up(now, STILL_WITHIN, moves)
        return []

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

    def _wait(self, now: float, seen: Observation) -> list[Ask]:
        if lacking := self._lacking(seen):
            self.give_up(now, STACK_WITHIN, lacking)
        else:
            self.enter(STANDING, now)
        return []

    def _lacking(self, seen: Observation) -> str:
        """What the run still needs, with the remedy; empty if it can begin."""
        if seen.position is None:
            return "nothing was heard on state/ee. Is the robot process running, on the same router and robot name?"
        if not seen.wrench_valid:
            return f"wrench/external is not valid. {seen.trouble}"
        if not seen.law:
            return "nothing was heard on control/status. Is the controller running?"
        if seen.law != self.run.law:
            wanted = self.run.law
            return f"the controller runs law {seen.law!r}, wanted {wanted!r}: start it with --set 'law=\"{wanted}\"'"
        if seen.mode == "stopped":
            return "the robot is stopped. Release it with: tandem resume"
        for service, heard in (("task", seen.task), ("base", seen.base)):
            if service in self.run.further and not heard:
                return f"nothing was heard on {service}/status. Start it with: tandem start {service}"
        if self.run.settings.get("sim", {}).get("scene") == "carry" and not seen.panel:
            return "there is no panel to carry: start the simulation with --set 'sim.scene=\"carry\"'"
        return ""

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
