"""The course of the load experiment: which step follows which, what each waits for and when it gives up.

Pure: it is told the time and what was heard last, and answers with the requests to send. It runs alike against real
processes and in simulated time.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from services.experiment import protocol
from services.experiment.protocol import Run, mass, unambiguous
from services.experiment.recording import Event
from shared import topics
from shared.topics import Query

STILL = 0.005  # [m/s]: a slower tool counts as still
STILL_FOR = 1.0  # [s]
AT_POSE = 0.02  # [m]: near enough to start the clock, ten seconds before the first bag
BACK_AT_POSE = 0.005  # [m] from where the first bag was hung: near enough to end early
TARE_DURATION = 1.0  # [s] averaged
TARE_AGAIN = 8  # times: when it is refused, or was taken too far from the pose to be exact there
ANSWER_WITHIN = 5.0  # [s] for the answer to a request, beyond what it takes by itself


class Failed(RuntimeError):
    """The experiment cannot go on; the text says what was awaited, what was seen and what to do."""


@dataclass(frozen=True)
class Seen:
    """What was heard last: tool position (3,) [m], speed [m/s], the law in force, error bound of force z [N]."""

    position: np.ndarray | None = None
    speed: float = float("inf")
    law: str = ""
    mode: str = ""
    wrench_valid: bool = False
    error_bound: float = 0.0
    trouble: str = ""


@dataclass(frozen=True)
class Ask:
    """A request to send; its answer comes back through `LoadSequence.answered`."""

    query: Query
    request: dict[str, Any]
    duration: float = 0.0


@dataclass
class LoadSequence:
    """Plays one run. Call `step` about ten times a second until `done`.

    Attributes:
        run: configuration that the stack must have.
        phase: what it does now, in words.
        start: time [s] at which the protocol's clock started, or None.
        events: what happened, in the caller's time.
        done: the run is complete.
    """

    run: Run
    phase: str = "waiting for the robot"
    start: float | None = None
    events: list[Event] = field(default_factory=list)
    done: bool = False
    _since: float | None = None
    _steady_since: float | None = None
    _pending: Ask | None = None
    _answer: dict[str, Any] | None = None
    _played: int = 0
    _retries: int = 0
    _rest: np.ndarray | None = None

    def step(self, now: float, seen: Seen) -> list[Ask]:
        """One step at time `now` [s, any origin].

        Raises:
            Failed: an awaited condition did not come true in time, or a request was refused.
        """
        if self._since is None:
            self._since = now
        if self._pending is not None:
            return self._await_answer(now)
        phases: dict[str, Callable[[float, Seen], list[Ask]]] = {
            "waiting for the robot": self._wait,
            "standing still before the tare": self._stand,
            "taking up the pose": self._take_up,
            "playing": self._play,
        }
        return phases[self.phase](now, seen)

    def answered(self, answer: dict[str, Any]) -> None:
        """Takes the reply to the last `Ask` (a map with `ok`)."""
        self._answer = answer

    def elapsed(self, now: float) -> float | None:
        """Time [s] on the protocol's clock, None before it starts."""
        return None if self.start is None else now - self.start

    def _wait(self, now: float, seen: Seen) -> list[Ask]:
        lacking = _lacking(seen, self.run)
        if lacking:
            self._give_up(now, 30.0, lacking)
            return []
        self._enter("standing still before the tare", now)
        return []

    def _stand(self, now: float, seen: Seen) -> list[Ask]:
        if not self._steady(now, seen, float("inf")):
            self._give_up(now, 60.0, f"the tool still moves at {1e3 * seen.speed:.0f} mm/s. {seen.trouble}")
            return []
        return self._ask(now, Ask(topics.WRENCH_TARE, {"duration": TARE_DURATION}, TARE_DURATION))

    def _take_up(self, now: float, seen: Seen) -> list[Ask]:
        if not self._steady(now, seen, AT_POSE):
            away = 1e3 * _distance(seen)
            self._give_up(now, 60.0, f"the tool is {away:.0f} mm from the pose to hold. {seen.trouble}")
            return []
        if unambiguous(seen.error_bound) > protocol.HEAVY:
            self._retries += 1
            if self._retries <= TARE_AGAIN:
                return self._ask(now, Ask(topics.WRENCH_TARE, {"duration": TARE_DURATION}, TARE_DURATION))
            raise Failed(
                f"the error bound of force z is {seen.error_bound:.2f} N: the heavier bag of {protocol.HEAVY:g} N "
                f"is not clearly over the limit ({unambiguous(seen.error_bound):.1f} N needed): lower sim.ft_noise"
            )
        self.start = now
        self.events.append(Event(now, "start", f"error bound of force z {seen.error_bound:.2f} N"))
        self._enter("playing", now)
        return []

    def _play(self, now: float, seen: Seen) -> list[Ask]:
        assert self.start is not None
        elapsed = now - self.start
        if self._played < len(_LOADS):
            at, _, weight = _LOADS[self._played]
            if elapsed >= at - 1e-6:
                self._rest = seen.position if self._played == 0 else self._rest
                return self._ask(now, Ask(topics.SIM_COMMAND, {"command": "load", "mass": mass(weight)}))
        elif elapsed >= protocol.END_AT or self._steady(now, seen, BACK_AT_POSE, self._rest):
            self.events.append(Event(now, "end"))
            self.done = True
        return []

    def _ask(self, now: float, ask: Ask) -> list[Ask]:
        self._pending, self._answer, self._since = ask, None, now
        return [ask]

    def _await_answer(self, now: float) -> list[Ask]:
        ask = self._pending
        assert ask is not None
        if self._answer is None:
            self._give_up(
                now,
                ask.duration + ANSWER_WITHIN,
                f"no answer on {ask.query.key}. Is {ask.query.server} running?",
            )
            return []
        self._pending = None
        if not self._answer.get("ok"):
            refused = f"{ask.query.key} was refused: {self._answer.get('error', 'no reason given')}"
            self._retries += 1
            if ask.query is not topics.WRENCH_TARE or self._retries > TARE_AGAIN:
                raise Failed(refused)
            self._enter(self.phase, now)  # a disturbance of a moment: stand still and ask again
            return []
        sent = now if self._since is None else self._since
        if ask.query is topics.WRENCH_TARE:
            self.events.append(Event(sent, "tare"))
            self._enter("taking up the pose", now)
        else:
            _, name, weight = _LOADS[self._played]
            self.events.append(Event(sent, name, f"{weight:g} N" if weight else "taken off"))
            self._played += 1
            self._steady_since = None
        return []

    def _enter(self, phase: str, now: float) -> None:
        self.phase, self._since, self._steady_since = phase, now, None

    def _steady(self, now: float, seen: Seen, within: float, place: np.ndarray | None = None) -> bool:
        """Whether the tool has been still and within a distance [m] of a place, the pose to hold, for STILL_FOR."""
        if seen.speed > STILL or (within < float("inf") and _distance(seen, place) > within):
            self._steady_since = None
            return False
        if self._steady_since is None:
            self._steady_since = now
        return now - self._steady_since >= STILL_FOR

    def _give_up(self, now: float, after: float, why: str) -> None:
        if self._since is not None and now - self._since > after:
            raise Failed(f"gave up {self.phase} after {after:.0f} s: {why}")


_LOADS = (
    (protocol.LIGHT_AT, "light", protocol.LIGHT),
    (protocol.HEAVY_AT, "heavy", protocol.HEAVY),
    (protocol.UNLOAD_AT, "unload", 0.0),
)


def _distance(seen: Seen, place: np.ndarray | None = None) -> float:
    if seen.position is None:
        return float("inf")
    return float(np.linalg.norm(seen.position - (np.array(protocol.HOLD[:3]) if place is None else place)))


def _lacking(seen: Seen, run: Run) -> str:
    if seen.position is None:
        return (
            "nothing was heard on state/ee. Is the robot process running, on the same router and robot name?"
        )
    if not seen.wrench_valid:
        return f"wrench/external is not valid. {seen.trouble}"
    if not seen.law:
        return "nothing was heard on control/status. Is the controller running?"
    if seen.law != run.law:
        return f"the controller runs law {seen.law!r}, wanted {run.law!r}: start it with --set 'law=\"{run.law}\"'"
    if seen.mode == "stopped":
        return "the robot is stopped. Release it with: tandem resume"
    return ""
