"""What the course of an experiment goes by: the newest word of each topic."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from shared import topics
from shared.service import Inputs
from shared.topics import Topic

INPUTS = (
    topics.STATE_EE,
    topics.WRENCH_EXTERNAL,
    topics.CONTROL_STATUS,
    topics.STATE_ROBOT,
    topics.TASK_STATUS,
    topics.BASE_STATUS,
    topics.SIM_WORLD,
)


@dataclass(frozen=True)
class Observation:
    """What was heard last.

    Attributes:
        position: of the tool (3,) [m]; None before.
        speed: of the tool [m/s].
        law: of the controller in force.
        mode: of the robot.
        wrench_valid: whether the external wrench is.
        error_bound: of force z [N].
        trouble: why the tool may not move as it should, in the services' own words.
        task: state of the task; "" if none was heard.
        reason: of the task's state.
        base: state of the base service; "" if none was heard.
        panel: whether there is one to carry.
        doing: what the simulated person is about; "" if nothing.
    """

    position: np.ndarray | None = None
    speed: float = float("inf")
    law: str = ""
    mode: str = ""
    wrench_valid: bool = False
    error_bound: float = 0.0
    trouble: str = ""
    task: str = ""
    reason: str = ""
    base: str = ""
    panel: bool = False
    doing: str = ""

    @classmethod
    def of(cls, inputs: Inputs) -> Observation:
        """The newest of what came in."""

        def said(topic: Topic, field: str, otherwise: Any = "") -> Any:
            reading = inputs.get(topic)
            return otherwise if reading is None else getattr(reading.message, field)

        wrench, status = inputs.get(topics.WRENCH_EXTERNAL), inputs.get(topics.CONTROL_STATUS)
        hand = said(topics.SIM_WORLD, "hand", None)
        return cls(
            position=said(topics.STATE_EE, "position", None),
            speed=float(np.linalg.norm(said(topics.STATE_EE, "linear", np.inf))),
            law=said(topics.CONTROL_STATUS, "law"),
            mode=said(topics.STATE_ROBOT, "mode"),
            wrench_valid=wrench is not None and wrench.header.valid,
            error_bound=0.0 if wrench is None else float(wrench.message.error_bound[2]),
            trouble=_trouble(wrench, status),
            task=said(topics.TASK_STATUS, "state"),
            reason=said(topics.TASK_STATUS, "reason"),
            base=said(topics.BASE_STATUS, "state"),
            panel=said(topics.SIM_WORLD, "panel", None) is not None,
            doing="" if hand is None else hand.doing,
        )


def _trouble(wrench: Any, status: Any) -> str:
    if wrench is None:
        return "Nothing was heard on wrench/external: is the wrench service running?"
    if wrench.message.fault:
        return f"The wrench service reports: {wrench.message.fault}."
    if status is not None and status.message.reason:
        return f"The controller says: {status.message.state}, {status.message.reason}"
    return ""
