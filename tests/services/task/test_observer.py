"""What the task believes of a message: nothing that is marked invalid, nothing old, and of a stop everything."""

from __future__ import annotations

import numpy as np
import pytest

from services.task.faults import TaskFault
from services.task.observer import GUARDED_MAX_AGE, WRENCH_MAX_AGE, Observer
from services.task.parameters import TaskParameters
from services.task.states import Observation
from services.task.vision.sight import Sight
from shared import topics
from shared.messages import ControlStatus, EndEffector, ExternalWrench, GripperState, Header, RobotStatus, Stop
from shared.schema.records import Record
from shared.service import Inputs, Reading

SETTINGS = TaskParameters()
ZERO3, ZERO6 = (0.0,) * 3, (0.0,) * 6
TOOL = EndEffector((0.5, -0.3, 0.9), (0.0, 0.0, 0.0, 1.0), ZERO3, ZERO3)
WRENCH = ExternalWrench((0.0, 0.0, -7.0), ZERO3, (0.2,) * 6, "payload", "")
CONTROL = ControlStatus("tracking", "", "certified", ZERO6, ZERO6, ZERO6, 0.0, 0.0, 50.0)
GRIPPER = GripperState(0.05, 12.0, True)
HEALTHY: dict[topics.Topic, Record] = {
    topics.STATE_EE: TOOL,
    topics.WRENCH_EXTERNAL: WRENCH,
    topics.CONTROL_STATUS: CONTROL,
    topics.STATE_GRIPPER: GRIPPER,
    topics.STATE_ROBOT: RobotStatus("ready", "", "omni", True, 0.3, 1.0, np.ones(3)),
}


def reading(message: Record, age: float = 0.01, valid: bool = True) -> Reading:
    return Reading(message, Header(5, 1, 0, valid), age, True)


def look(
    changed: dict[topics.Topic, Reading], observer: Observer | None = None, refused: topics.Topic | None = None
) -> tuple[Observation, set[str]]:
    """What is seen, and the names of the faults; the marker's are left out. All that comes on one topic is refused."""
    readings = {topic.key: reading(message) for topic, message in HEALTHY.items() if topic != refused}
    readings |= {topic.key: changed[topic] for topic in changed}
    inputs = Inputs(readings, _refused={refused.key: "7 messages rejected"} if refused else {})
    seen, faults = (observer or Observer(SETTINGS)).look(inputs, Sight(SETTINGS))
    return seen, {fault.name for fault in faults} - {"camera_never"}


def test_what_is_healthy_is_believed() -> None:
    seen, faults = look({})
    assert not faults and seen.guarded and seen.gripper == GRIPPER and seen.force == -7.0


@pytest.mark.parametrize("doubt", ["old", "invalid"])
@pytest.mark.parametrize(
    ("topic", "max_age", "blank"),
    [
        (topics.WRENCH_EXTERNAL, WRENCH_MAX_AGE, {"wrench": None}),
        (topics.CONTROL_STATUS, GUARDED_MAX_AGE, {"guarded": False}),
        (topics.STATE_GRIPPER, topics.STATE_GRIPPER.max_age, {"gripper": None}),
    ],
    ids=str,
)
def test_what_is_doubtful_is_not_known(
    topic: topics.Topic, max_age: float, blank: dict[str, object], doubt: str
) -> None:
    old = doubt == "old"
    seen, faults = look({topic: reading(HEALTHY[topic], max_age + 0.01 if old else 0.01, valid=old)})
    assert {name: getattr(seen, name) for name in blank} == blank
    if topic == topics.WRENCH_EXTERNAL:
        assert faults == {"wrench_silent" if old else "wrench_invalid"}
        with pytest.raises(ValueError, match="not known"):
            _ = seen.force


@pytest.mark.parametrize(
    ("topic", "name"),
    [
        (topics.WRENCH_EXTERNAL, "wrench_refused"),
        (topics.CONTROL_STATUS, "controller_refused"),
        (topics.SENSOR_CAMERA, "camera_refused"),
        (topics.STATE_GRIPPER, "gripper_refused"),
    ],
    ids=str,
)
def test_what_comes_but_is_refused_is_said_to_be(topic: topics.Topic, name: str) -> None:
    seen, faults = look({}, refused=topic)
    assert name in faults | {seen.unsure.name}
    assert TaskFault(name, "7 messages rejected").sentence == "7 messages rejected"
    if name == "camera_refused":
        assert seen.doubt is not None and seen.doubt.name == name


@pytest.mark.parametrize("valid", [True, False])
def test_a_stop_is_believed_whoever_says_so_and_its_release_only_if_it_is_valid(valid: bool) -> None:
    observer = Observer(SETTINGS)
    assert look({topics.STOP: reading(Stop(True, "red"), valid=valid)}, observer)[1] == {"stop"}
    assert look({}, observer)[1] == {"stop"}, "it stays"
    released = {topics.STOP: reading(Stop(False), valid=valid)}
    assert look(released, observer)[1] == (set() if valid else {"stop"})


def test_a_robot_that_says_that_it_is_stopped_is() -> None:
    stopped = RobotStatus("stopped", "red button", "omni", True, 0.3, 1.0, np.ones(3))
    assert look({topics.STATE_ROBOT: reading(stopped)})[1] == {"robot_stopped"}
    assert not look({topics.STATE_ROBOT: reading(stopped, age=topics.STATE_ROBOT.max_age + 0.1)})[1]


def test_another_session_is_a_restart_once() -> None:
    observer = Observer(SETTINGS)
    look({}, observer)
    again = {topics.STATE_EE: Reading(TOOL, Header(0, 2, 0, True), 0.01, True)}
    assert look(again, observer)[1] == {"robot_restarted"}
    assert not look(again, observer)[1]
