"""What the task believes of a message: nothing that is marked invalid, nothing old, and of a stop everything."""

from __future__ import annotations

import numpy as np
import pytest

from services.task.observer import GUARDED_MAX_AGE, WRENCH_MAX_AGE, Observer
from services.task.parameters import TaskParameters
from services.task.states import Observation
from services.task.vision.marker_tracker import MarkerTracker
from shared.messages import (
    ControlStatus,
    EndEffector,
    ExternalWrench,
    GripperState,
    Header,
    RobotStatus,
    Stop,
)
from shared.schema.records import Record
from shared.service import Inputs, Reading
from shared.topics import (
    CONTROL_STATUS,
    STATE_EE,
    STATE_GRIPPER,
    STATE_ROBOT,
    STOP,
    WRENCH_EXTERNAL,
    Topic,
)

SETTINGS = TaskParameters()
ZERO3, ZERO6 = (0.0,) * 3, (0.0,) * 6
TOOL = EndEffector((0.5, -0.3, 0.9), (0.0, 0.0, 0.0, 1.0), ZERO3, ZERO3)
WRENCH = ExternalWrench((0.0, 0.0, -7.0), ZERO3, (0.2,) * 6, "payload", "")
CONTROL = ControlStatus("tracking", "", "certified", ZERO6, ZERO6, ZERO6, 0.0, 0.0, 50.0)
GRIPPER = GripperState(0.05, 12.0, True)
HEALTHY: dict[Topic, Record] = {
    STATE_EE: TOOL,
    WRENCH_EXTERNAL: WRENCH,
    CONTROL_STATUS: CONTROL,
    STATE_GRIPPER: GRIPPER,
    STATE_ROBOT: RobotStatus("ready", "", "omni", True, 0.3, 1.0, np.ones(3)),
}


def reading(message: Record, age: float = 0.01, valid: bool = True) -> Reading:
    return Reading(message, Header(5, 1, 0, valid), age, True)


def look(changed: dict[Topic, Reading], observer: Observer | None = None) -> tuple[Observation, set[str]]:
    """What is seen, and the names of the faults; the marker's are left out."""
    readings = {topic.key: reading(message) for topic, message in HEALTHY.items()}
    readings |= {topic.key: changed[topic] for topic in changed}
    tracker = MarkerTracker(SETTINGS)
    seen, faults = (observer or Observer(SETTINGS)).look(Inputs(readings), tracker)
    return seen, {fault.name for fault in faults} - {"camera_never"}


def test_what_is_healthy_is_believed() -> None:
    seen, faults = look({})
    assert not faults and seen.guarded and seen.gripper == GRIPPER and seen.force == -7.0


@pytest.mark.parametrize("how", [{"valid": False}, {"age": WRENCH_MAX_AGE + 0.01}])
def test_a_doubtful_wrench_is_none(how: dict) -> None:
    seen, faults = look({WRENCH_EXTERNAL: reading(WRENCH, **how)})
    assert seen.wrench is None and faults & {"wrench_invalid", "wrench_silent"}
    with pytest.raises(ValueError, match="not known"):
        _ = seen.force


@pytest.mark.parametrize("how", [{"valid": False}, {"age": GUARDED_MAX_AGE + 0.01}])
def test_a_doubtful_controller_keeps_no_limits(how: dict) -> None:
    assert not look({CONTROL_STATUS: reading(CONTROL, **how)})[0].guarded


@pytest.mark.parametrize("how", [{"valid": False}, {"age": STATE_GRIPPER.max_age + 0.01}])
def test_a_doubtful_gripper_is_not_known(how: dict) -> None:
    assert look({STATE_GRIPPER: reading(GRIPPER, **how)})[0].gripper is None


@pytest.mark.parametrize("valid", [True, False])
def test_a_stop_is_believed_whoever_says_so_and_its_release_only_if_it_is_valid(valid: bool) -> None:
    observer = Observer(SETTINGS)
    assert look({STOP: reading(Stop(True, "red"), valid=valid)}, observer)[1] == {"stop"}
    assert look({}, observer)[1] == {"stop"}, "it stays"
    released = {STOP: reading(Stop(False), valid=valid)}
    assert look(released, observer)[1] == (set() if valid else {"stop"})


def test_a_robot_that_says_that_it_is_stopped_is() -> None:
    stopped = RobotStatus("stopped", "red button", "omni", True, 0.3, 1.0, np.ones(3))
    assert look({STATE_ROBOT: reading(stopped)})[1] == {"robot_stopped"}
    assert not look({STATE_ROBOT: reading(stopped, age=STATE_ROBOT.max_age + 0.1)})[1]


def test_another_session_is_a_restart_once() -> None:
    observer = Observer(SETTINGS)
    look({}, observer)
    again = {STATE_EE: Reading(TOOL, Header(0, 2, 0, True), 0.01, True)}
    assert look(again, observer)[1] == {"robot_restarted"}
    assert not look(again, observer)[1]
