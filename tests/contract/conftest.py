"""What has to pass: every robot process, in whatever way it is started. A bridge is one more row of ``ROBOTS``."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from shared.topics import COMMAND_EE_TWIST, Topic
from tests.conftest import Router, _processes
from tests.contract.robot import Commander, Robot, RobotProcess, lives_through

ROBOTS = {
    "sim": RobotProcess("services.sim"),
    "mock": RobotProcess(
        "services.mock", with_a_kilogram=("--set", "wrench=[0.0, 0.0, -9.81, 0.0, 0.0, 0.0]"), camera=False, world=False
    ),
}


@pytest.fixture(scope="module", params=ROBOTS.values(), ids=list(ROBOTS))
def kind(request: pytest.FixtureRequest) -> RobotProcess:
    return request.param


@pytest.fixture(scope="module")
def robot(kind: RobotProcess, shared_router: Router, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Robot]:
    """One process for all tests of a file: it has to live through all of them."""
    with _processes(tmp_path_factory.mktemp("robot")) as start_process:
        robot = Robot(shared_router.endpoint)
        with lives_through(robot, start_process(kind.module, *robot.options)):
            yield robot


@pytest.fixture
def topic() -> Topic:
    """Of the commands."""
    return COMMAND_EE_TWIST


def _commander(shared_router: Router, topic: Topic) -> Iterator[Commander]:
    commander = Commander(shared_router.endpoint, topic)
    yield commander
    commander.close()


commander = pytest.fixture(_commander, name="commander")
second = pytest.fixture(_commander, name="second")
