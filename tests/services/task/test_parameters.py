"""The parameters: documented, consistent, and with their defaults those of the simulated scene."""

from __future__ import annotations

import numpy as np
import pytest

from services.sim.camera.marker import ROTATION
from services.sim.parameters import SimParameters
from services.task.faults import FAULTS
from services.task.parameters import TaskParameters
from services.task.states import State
from services.task.vision.detection import Detector
from shared import topics
from shared.messages import GripperCommand, HeadCommand
from shared.parameters import Refused
from shared.robot.tiago import GRIPPER_RANGES
from tests.services.sim.rig import Rig
from tests.support.processes import ROOT


def test_panel_and_marker_are_those_of_the_simulation() -> None:
    sim, task = SimParameters(), TaskParameters()
    assert (task.marker_id, task.marker_size) == (sim.marker_id, sim.marker_size)
    assert task.panel_mass == sim.panel_mass
    assert (task.panel_length, task.panel_width, task.panel_thickness) == sim.panel_size


def test_the_grasp_is_the_middle_of_the_panel_s_edge() -> None:
    sim, task = SimParameters(), TaskParameters()
    grasp = sim.scenery().marker_in_panel + ROTATION @ np.array(task.grasp_position)
    assert grasp == pytest.approx([-sim.panel_size[0] / 2, 0.0, 0.0])


def test_the_gripper_can_do_what_the_task_wants() -> None:
    task = TaskParameters()
    assert task.gripper_open <= GRIPPER_RANGES["opening"][1] and task.gripper_effort <= GRIPPER_RANGES["effort"][1]


@pytest.mark.parametrize("scene", ["full", "carry"])
def test_the_task_looks_where_the_marker_is_and_open_fingers_do_not_hide_it(scene: str) -> None:
    task, rig = TaskParameters(), Rig(scene=scene)
    rig.stack.client.publish(topics.COMMAND_GRIPPER, GripperCommand(task.gripper_open, task.gripper_effort))
    rig.stack.client.publish(topics.COMMAND_HEAD, HeadCommand(task.head_pan, task.head_tilt))
    rig.run(1.5)
    assert rig.last(topics.STATE_GRIPPER).opening == pytest.approx(task.gripper_open)
    (found,) = Detector(task.marker_size).find(rig.last(topics.SENSOR_CAMERA))
    assert found.number == task.marker_id and found.solutions


@pytest.mark.parametrize("number", [8, 9, 17, 47])
def test_a_marker_that_hides_a_mirrored_picture_is_refused(number: int) -> None:
    with pytest.raises(Refused, match=f"marker_id is {number}, which reads the same in a mirrored picture"):
        TaskParameters.of({"marker_id": number})


def test_nothing_is_missing_in_the_documentation() -> None:
    text = (ROOT / "docs" / "task.md").read_text(encoding="utf-8")
    for name, (kind, sentence) in FAULTS.items():
        assert f"| `{name}` | {kind.value} | {sentence.replace('{}', '...')} |" in text
    for state in State:
        assert f"| {state.value} |" in text
    for name in TaskParameters.model_fields:
        assert f"| `{name}` |" in text


def test_a_gripper_that_opens_no_wider_than_the_panel_is_refused() -> None:
    with pytest.raises(Refused, match=r"gripper_open is 0\.05"):
        TaskParameters.of({"gripper_open": 0.05})
