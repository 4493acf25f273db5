"""The player, a service: advances the course of a run, asks what that wants, records every topic.

The same class runs in a process of its own over Zenoh and beside the other services in simulated time; only the way
to ask a query differs, since nobody may wait inside simulated time.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

from services.experiment.play.course import Ask, Course, Failed
from services.experiment.play.observation import INPUTS, Observation
from services.recorder.topics import everything
from shared import topics
from shared.clock import Clock, seconds
from shared.messages import ControlTarget
from shared.parameters import Parameters
from shared.service import Inputs, Output, Service, Wiring
from shared.wire.bus import Bus, OnPayload

PERIOD = 0.1  # [s] of a step, and between two `control/target`
Answered = Callable[[dict[str, Any]], None]
OnHeard = Callable[[str, int, bytes], None]
"""Takes key, steady clock [ns] and payload of what was heard, from any thread, and returns at once."""


class Player(Service[Parameters]):
    """Plays one run. Its `step` is called every `PERIOD`; `finished` tells when to stop.

    Args:
        course: of the run for which the stack was started.
        target: to hold meanwhile; None if a task of the stack says what to hold.
        meta: what is to be said of the run besides its configuration.
        bus: where everything is recorded from.
        clock: the clock of the recording.
        ask: sends a request without waiting; the answer (a map with `ok`) may be handed over from any thread.
        record: is given everything.
    """

    max_delay = 1.0

    def __init__(
        self,
        course: Course,
        target: ControlTarget | None,
        meta: dict[str, Any],
        bus: Bus,
        clock: Clock,
        ask: Callable[[Ask, Answered], None],
        record: OnHeard,
    ) -> None:
        self.wiring = Wiring(
            "experiment", driver=PERIOD, optional=INPUTS, shares=() if target is None else (topics.CONTROL_TARGET,)
        )
        super().__init__(Parameters())
        self.course = course
        self._target = target
        self._meta = meta
        self._clock = clock
        self._ask = ask
        # Pictures only where the task has them taken anyway.
        for topic in everything(camera=topics.TASK_STATUS.publisher in course.run.further):
            bus.subscribe(topic.key, self._listener(topic.key, record))

    def step(self, inputs: Inputs, dt: float) -> list[Output]:
        """Advances the course and repeats the target.

        Raises:
            Failed: the experiment cannot go on.
        """
        if who := inputs.taken(topics.CONTROL_TARGET):
            raise Failed(f"{who} publishes {topics.CONTROL_TARGET.key} and was first: end it, then play again")
        for ask in self.course.step(self.now(), Observation.of(inputs)):
            self._ask(ask, self.course.answered)
        return [] if self._target is None else [Output(topics.CONTROL_TARGET, self._target)]

    def now(self) -> float:
        """The recording's clock [s]."""
        return seconds(self._clock.now_ns())

    @property
    def finished(self) -> bool:
        """Whether the run is complete."""
        return self.course.done

    def about(self, **meta: Any) -> dict[str, Any]:
        """What the run is; `meta` is said besides."""
        run = self.course.run
        return {
            "name": run.name,
            "title": run.title,
            "law": run.law,
            "rate": run.rate,
            "settings": run.settings,
            **self._meta,
            **meta,
        }

    def end(self) -> dict[str, Any]:
        """What took place: where the protocol's clock starts, and events, on the recording's clock [s]."""
        events = [dataclasses.astuple(event) for event in self.course.events]
        return {"start": self.course.start or 0.0, "events": events}

    def _listener(self, key: str, record: OnHeard) -> OnPayload:
        return lambda payload: record(key, self._clock.now_ns(), payload)
