"""The load experiment as a service: publishes the target, sends the loads, records every topic.

The same class runs in a process of its own over Zenoh and beside the other services in simulated time; only the way
to ask a query differs, since nobody may wait inside simulated time.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from services.experiment import protocol
from services.experiment.protocol import Run
from services.experiment.recording import Recorder, Recording
from services.experiment.sequence import Ask, LoadSequence, Seen
from shared import topics
from shared.bus import Bus, OnPayload
from shared.clock import Clock, seconds
from shared.faults import Fault
from shared.messages import ControlTarget, EndEffector, ExternalWrench
from shared.parameters import Parameters, Refused
from shared.service import Inputs, Output, Wiring
from shared.spatial import quaternion_from_rpy
from shared.topics import Query, Topic, health_topic

Answered = Callable[[dict[str, Any]], None]
RECORDED: tuple[Topic, ...] = (
    *(topic for topic in topics.TOPICS if topic is not topics.SENSOR_CAMERA),
    *(health_topic(name) for name in ("sim", "wrench", "controller")),
)


class LoadExperiment:
    """Plays one run. Its `step` is called every `protocol.TARGET_PERIOD`; `finished` tells when to stop.

    Args:
        run: the configuration that the stack was started with.
        bus: where everything is recorded from.
        clock: the clock of the recording.
        ask: sends a request without waiting; the answer (a map with `ok`) may be handed over from any thread.
    """

    def __init__(self, run: Run, bus: Bus, clock: Clock, ask: Callable[[Ask, Answered], None]) -> None:
        self.wiring = Wiring(
            "experiment",
            driver=protocol.TARGET_PERIOD,
            optional=(topics.STATE_EE, topics.WRENCH_EXTERNAL, topics.CONTROL_STATUS, topics.STATE_ROBOT),
        )
        self.parameters = Parameters()
        self.max_delay = 1.0
        self.sequence = LoadSequence(run)
        self._clock = clock
        self._ask = ask
        self._recorder = Recorder()
        self._target = ControlTarget(
            position=np.array(protocol.HOLD[:3]),
            orientation=quaternion_from_rpy(*protocol.HOLD[3:]),
            force_limit=np.array(protocol.FORCE_LIMIT),
            torque_limit=np.array(protocol.TORQUE_LIMIT),
        )
        for topic in RECORDED:
            bus.subscribe(topic.key, self._listener(topic))

    def step(self, inputs: Inputs, dt: float) -> list[Output]:
        """Advances the sequence and repeats the target.

        Raises:
            Failed: the experiment cannot go on.
        """
        for ask in self.sequence.step(self.now(), _seen(inputs)):
            self._ask(ask, self.sequence.answered)
        return [Output(topics.CONTROL_TARGET, self._target)]

    def brake(self, fault: Fault, dt: float) -> list[Output]:
        """Publishes nothing: the last target stays in force, and the controller does the braking."""
        return []

    def query(self, query: Query, request: dict[str, Any], reply: Answered) -> None:
        """Answers no queries."""
        raise Refused(f"{query.key} is not served by the experiment")

    def apply(self, parameters: Parameters) -> None:
        """Has no parameters."""

    def notes(self) -> str:
        """Nothing to say beyond the progress."""
        return ""

    def now(self) -> float:
        """The recording's clock [s]."""
        return seconds(self._clock.now_ns())

    @property
    def finished(self) -> bool:
        """Whether the run is complete."""
        return self.sequence.done

    def recording(self, **meta: Any) -> Recording:
        """Everything heard, on the protocol's clock; `meta` is added to what describes the run."""
        run = self.sequence.run
        described = {
            "name": run.name,
            "title": run.title,
            "law": run.law,
            "rate": run.rate,
            "settings": run.settings,
            "force_limit": list(protocol.FORCE_LIMIT),
            "torque_limit": list(protocol.TORQUE_LIMIT),
            **meta,
        }
        start = self.sequence.start
        return self._recorder.finish(described, self.sequence.events, 0.0 if start is None else start)

    def _listener(self, topic: Topic) -> OnPayload:
        return lambda payload: self._recorder.heard(topic, self.now(), payload)


def _seen(inputs: Inputs) -> Seen:
    tool, wrench = inputs.get(topics.STATE_EE), inputs.get(topics.WRENCH_EXTERNAL)
    status, robot = inputs.get(topics.CONTROL_STATUS), inputs.get(topics.STATE_ROBOT)
    position, speed, bound = None, float("inf"), 0.0
    if tool is not None:
        assert isinstance(tool.message, EndEffector)
        position, speed = tool.message.position, float(np.linalg.norm(tool.message.linear))
    if wrench is not None:
        assert isinstance(wrench.message, ExternalWrench)
        bound = float(wrench.message.error_bound[2])
    return Seen(
        position=position,
        speed=speed,
        law=status.message.law if status is not None else "",
        mode=robot.message.mode if robot is not None else "",
        wrench_valid=wrench is not None and wrench.header.valid,
        error_bound=bound,
        trouble=_trouble(wrench, status),
    )


def _trouble(wrench: Any, status: Any) -> str:
    """Why the tool may not move as it should, in the services' own words."""
    if wrench is None:
        return "Nothing was heard on wrench/external: is the wrench service running?"
    if wrench.message.fault:
        return f"The wrench service reports: {wrench.message.fault}."
    if status is not None and status.message.reason:
        return f"The controller says: {status.message.state}, {status.message.reason}"
    return ""
