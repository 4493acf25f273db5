"""Messages that say what a test wants to hear, and nothing else."""

from __future__ import annotations

from typing import Any

import numpy as np

from services.viewer.sentence import Known, Told
from shared.messages import ControlStatus, Health, RobotStatus, TaskStatus
from shared.schema.records import Record
from shared.topics import CONTROL_STATUS, STATE_ROBOT, TASK_STATUS, Topic, health_topic

LIMIT = np.array((10.0, 10.0, 25.0, 0.5, 3.0, 3.0))
LEFT = np.array((9.0, 8.0, 20.0, 0.2, 2.5, 2.0))


def robot(mode: str = "ready", reason: str = "") -> RobotStatus:
    return RobotStatus(mode, reason, "omni", True, 0.3, 1.0, np.ones(3))


def control(state: str = "tracking", reason: str = "", **fields: Any) -> ControlStatus:
    """A status with limits, all well within them unless the fields say otherwise."""
    usual: dict[str, Any] = {"margin": LEFT, "active": np.zeros(6), "limit": LIMIT, "nominal": np.zeros(6)}
    still = {"twist": np.zeros(6), "relaxation": 0.0, "lyapunov": 0.0, "solve_us": 0.0}
    return ControlStatus(state=state, reason=reason, law="certified", **(still | usual | fields))


def at(axis: int, side: float, used: float, *more: tuple[int, float, float]) -> dict[str, Any]:
    """Fields of a status in which limits are active: axis, side, and how much of the limit is used."""
    margin, active = LEFT.copy(), np.zeros(6)
    for one, way, share in ((axis, side, used), *more):
        margin[one], active[one] = LIMIT[one] - share, way
    return {"margin": margin, "active": active}


def task(state: str, reason: str = "") -> TaskStatus:
    return TaskStatus(state, 3.0, reason, 0.0, 0.8, None)


def health(state: str = "ok", detail: str = "") -> Health:
    return Health(state, detail, 100.0, 300.0, 900.0, 0, {})


def known(*messages: Record, ages: dict[str, float] | None = None, **healths: Health) -> Known:
    """What was heard: messages by their kind, and the healths of services; a robot and a controller that work."""
    kinds: dict[type[Record], Topic] = {
        RobotStatus: STATE_ROBOT,
        ControlStatus: CONTROL_STATUS,
        TaskStatus: TASK_STATUS,
    }
    said: dict[str, Record] = {STATE_ROBOT.key: robot(), CONTROL_STATUS.key: control()}
    said |= {kinds[type(message)].key: message for message in messages}
    said |= {health_topic(name).key: message for name, message in healths.items()}
    return {key: Told(message, (ages or {}).get(key, 0.02)) for key, message in said.items()}
