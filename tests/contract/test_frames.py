"""Frames, units and signs of a robot process: what it measures and how it moves belong together."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from services.cli.check.weighing import wrench_in_base
from shared.spatial import rotation_matrix, rotation_vector
from shared.topics import SENSOR_FT, STATE_EE
from tests.conftest import Router, _processes
from tests.contract.robot import PATIENCE, ZERO, Commander, Robot, RobotProcess
from tests.support.wait import eventually

pytestmark = pytest.mark.processes

SPEED, TURN = 0.05, 0.2
WEIGHT = np.array((0.0, 0.0, -9.81))
axes = pytest.mark.parametrize("axis", range(3), ids="xyz")
signs = pytest.mark.parametrize("sign", [1.0, -1.0], ids=["forth", "back"])


def along(axis: int, size: float) -> tuple[float, ...]:
    vector = [0.0, 0.0, 0.0]
    vector[axis] = size
    return tuple(vector)


@axes
@signs
def test_the_tool_moves_as_commanded(robot: Robot, commander: Commander, axis: int, sign: float) -> None:
    robot.rests()
    start, turned = robot.tool.position, robot.rotation
    before = robot.heard[STATE_EE.key][-1].header.seq
    robot.follow(commander, along(axis, sign * SPEED), ZERO, lambda: sign * (robot.tool.position - start)[axis] > 0.03)
    moved = robot.tool.position - start
    assert np.linalg.norm(np.delete(moved, axis)) < 0.1 * np.linalg.norm(moved)
    assert np.linalg.norm(rotation_vector(robot.rotation @ turned.T)) < 0.02
    speeds = [heard.message.linear for heard in robot.all(STATE_EE) if heard.header.seq > before]
    fastest = max(speeds, key=np.linalg.norm)
    assert fastest[axis] == pytest.approx(sign * SPEED, rel=0.2)


@axes
@signs
def test_the_tool_turns_as_commanded_about_its_origin(
    robot: Robot, commander: Commander, axis: int, sign: float
) -> None:
    robot.rests()
    start, turned = robot.tool.position, robot.rotation
    sensor, offset = rotation_matrix(robot.sample.orientation), robot.sample.tool_offset

    def rotation() -> np.ndarray:
        return rotation_vector(robot.rotation @ turned.T)

    robot.follow(commander, ZERO, along(axis, sign * TURN), lambda: sign * rotation()[axis] > 0.1)
    assert np.linalg.norm(np.delete(rotation(), axis)) < 0.1 * np.linalg.norm(rotation())
    assert np.linalg.norm(robot.tool.position - start) < 0.01
    # The sensor is fixed to the tool: it turns with it, and sees the tool's origin where it was.
    with_sensor = rotation_vector(rotation_matrix(robot.sample.orientation) @ sensor.T)
    assert with_sensor == pytest.approx(rotation(), abs=0.02)
    assert robot.sample.tool_offset == pytest.approx(offset, abs=1e-9)


@pytest.fixture
def with_a_kilogram(
    kind: RobotProcess, robot: Robot, shared_router: Router, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Robot]:
    """The robot once a mass of 1 kg hangs from its tool."""
    if kind.with_a_kilogram is None:
        assert robot.ask("sim/command", command="load", mass=1.0) == {"ok": True}
        yield robot
        return
    with _processes(tmp_path_factory.mktemp("loaded")) as start_process:
        # Under a name of its own: two robots of one name would be two publishers.
        loaded = Robot(shared_router.endpoint, "loaded")
        start_process(kind.module, *loaded.options, *kind.with_a_kilogram)
        yield loaded.started()
        loaded.close()


def test_a_kilogram_pulls_down(robot: Robot, request: pytest.FixtureRequest) -> None:
    robot.rests()
    eventually(lambda: len(robot.all(SENSOR_FT)) >= 100, PATIENCE, "a hundred samples")
    force, torque = wrench_in_base(robot)
    loaded = request.getfixturevalue("with_a_kilogram")

    def measured() -> bool:
        present_force, present_torque = wrench_in_base(loaded)
        return (
            np.linalg.norm(present_force - force - WEIGHT) < 0.5
            # It hangs from the tool's origin: no torque about it, wherever the sensor is.
            and np.linalg.norm(present_torque - torque) < 0.15
        )

    eventually(measured, PATIENCE, "the sensor shows -9.81 N and no torque about the tool's origin")
