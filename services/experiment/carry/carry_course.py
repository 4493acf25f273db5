"""The course of the carry: tare, the person's script and the task's start, then its states until it is done."""

from __future__ import annotations

from services.experiment.carry import carry_protocol as protocol
from services.experiment.play.course import STANDING, STILL, Ask, Course, Run
from services.experiment.play.observation import Observation
from services.experiment.play.recording import Event
from shared import topics

AFTERWARDS = 3.0  # [s] recorded after the end: what was set down has to stay where it is
GIVEN_UP = ("holding", "idle")  # states of the task in which it goes on only if somebody says so


class CarrySequence(Course):
    """Starts person and task, covers the marker once the panel is held, and waits for the end.

    Args:
        run: configuration that the stack must have.
        script: of the person, as `sim/command hand` takes it; None for the run's own.
    """

    def __init__(self, run: Run, script: str | None = None) -> None:
        super().__init__(
            run,
            {
                STANDING: self._stand,
                "placing the person": self._place,
                "starting the task": self._start,
                "playing": self._play,
            },
        )
        self._script = protocol.SCRIPTS[run.name.rpartition("-")[2]] if script is None else script
        self._state = ""
        self._doing = ""
        self._ended: float | None = None

    def _stand(self, now: float, seen: Observation) -> list[Ask]:
        return self.tare_when(seen.speed <= STILL, now, seen)

    def _place(self, now: float, _seen: Observation) -> list[Ask]:
        return self.ask(now, Ask(topics.SIM_COMMAND, {"command": "hand", "script": self._script}))

    def _start(self, now: float, _seen: Observation) -> list[Ask]:
        return self.ask(now, Ask(topics.TASK_COMMAND, {"command": "start"}))

    def meanwhile(self, now: float, seen: Observation) -> list[Ask]:
        """What else to ask for at a step while the carry is played: nothing. For those who derive from this."""
        return []

    def _play(self, now: float, seen: Observation) -> list[Ask]:
        assert self.start is not None
        if asks := self.meanwhile(now, seen):
            return asks
        if seen.doing != self._doing:
            self._doing = seen.doing
            if seen.doing:
                self.events.append(Event(now, f"person: {seen.doing}"))
        if seen.task != self._state:
            self._state = seen.task
            self.events.append(Event(now, seen.task, seen.reason))
            if seen.task == "carrying" and all(event.name != "covered" for event in self.events):
                return self.ask(now, Ask(topics.SIM_COMMAND, {"command": "cover_marker"}))
        self._end(now, seen)
        return []

    def _end(self, now: float, seen: Observation) -> None:
        assert self.start is not None
        over = (seen.task == "done" and not seen.doing) or (
            seen.task in GIVEN_UP and now - self.start > 1.0 and self._state == seen.task
        )
        if not over:
            self._ended = None
        elif self._ended is None:
            self._ended = now
        late = now - self.start > protocol.END_AT
        if late or (self._ended is not None and now - self._ended >= AFTERWARDS):
            self.events.append(Event(now, "end", "" if self._ended is not None else "out of time"))
            self.done = True

    def accepted(self, ask: Ask, sent: float, now: float) -> None:
        """One step further; what was asked meanwhile is none."""
        if ask.query is topics.WRENCH_TARE:
            self.events.append(Event(sent, "tare"))
            self.enter("placing the person", now)
        elif self.phase == "placing the person":
            self.enter("starting the task", now)
        elif self.phase == "starting the task":
            self.start = now
            self.events.append(Event(now, "start"))
            self.enter("playing", now)
        elif ask.request["command"] == "cover_marker":
            self.events.append(Event(now, "covered", "the marker"))
