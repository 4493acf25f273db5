"""What the course of an experiment goes by: the newest word of each topic."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from shared import topics
from shared.messages import EndEffector, ExternalWrench
from shared.service import Inputs

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
        tool, wrench = inputs.get(topics.STATE_EE), inputs.get(topics.WRENCH_EXTERNAL)
        status, robot = inputs.get(topics.CONTROL_STATUS), inputs.get(topics.STATE_ROBOT)
        task, base = inputs.get(topics.TASK_STATUS), inputs.get(topics.BASE_STATUS)
        world = inputs.get(topics.SIM_WORLD)
        position, speed, bound = None, float("inf"), 0.0
        if tool is not None:
            assert isinstance(tool.message, EndEffector)
            position, speed = tool.message.position, float(np.linalg.norm(tool.message.linear))
        if wrench is not None:
            assert isinstance(wrench.message, ExternalWrench)
            bound = float(wrench.message.error_bound[2])
        hand = world.message.hand if world is not None else None
        return cls(
            position=position,
            speed=speed,
            law=status.message.law if status is not None else "",
            mode=robot.message.mode if robot is not None else "",
            wrench_valid=wrench is not None and wrench.header.valid,
            error_bound=bound,
            trouble=_trouble(wrench, status),
            task=task.message.state if task is not None else "",
            reason=task.message.reason if task is not None else "",
            base=base.message.state if base is not None else "",
            panel=world is not None and world.message.panel is not None,
            doing=hand.doing if hand is not None else "",
        )


def _trouble(wrench: Any, status: Any) -> str:
    if wrench is None:
        return "Nothing was heard on wrench/external: is the wrench service running?"
    if wrench.message.fault:
        return f"The wrench service reports: {wrench.message.fault}."
    if status is not None and status.message.reason:
        return f"The controller says: {status.message.state}, {status.message.reason}"
    return ""
