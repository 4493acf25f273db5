"""Four robots at one router: each follows its own controller, and what befalls one does not touch the others."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, closing

import numpy as np
import pytest

from shared.messages import ControlTarget, Stop
from shared.spatial import Array
from shared.topics import CONTROL_STATUS, CONTROL_TARGET, STATE_EE, STATE_ROBOT, STOP
from shared.wire.client import Client
from shared.wire.zenoh import ZenohBus
from tests.conftest import Router, StartProcess, _processes
from tests.faults import programs
from tests.faults.chain import OPTIONS, PATIENCE
from tests.support.processes import Process
from tests.support.wait import eventually

pytestmark = pytest.mark.processes

RATE = 30.0  # [Hz] of each
START = np.array(programs.POSITION)
AWAY = 8.0  # [m] to the target: none arrives
DIRECTIONS = {"first": (1, 0, 0), "second": (-1, 0, 0), "third": (0, 1, 0), "fourth": (0, -1, 0)}


class Robot:
    """A mock robot with its wrench and controller, and who leads it in a direction of its own."""

    def __init__(self, name: str, endpoint: str, start: StartProcess) -> None:
        self.direction = np.array(DIRECTIONS[name], dtype=float)

        def service(kind: str, *options: str) -> Process:
            return start(f"services.{kind}", "--robot", name, "--connect", endpoint, *options)

        service("mock", "--set", f"rate={RATE}")
        service("wrench", *OPTIONS["wrench"])
        self.controller = service("controller", *OPTIONS["controller"])
        self.bus = ZenohBus(name, endpoint)
        self.client = Client(self.bus)
        self.tool, self.gate, self.status = map(self.client.watch, (STATE_EE, STATE_ROBOT, CONTROL_STATUS))

    def aim(self) -> None:
        """Say where to go, as an operator does again and again."""
        place = START + AWAY * self.direction
        self.client.publish(CONTROL_TARGET, ControlTarget(place, programs.LEVEL, (25.0,) * 3, (10.0,) * 3))

    def gone(self) -> Array:
        """Way of the tool (3,) [m] since the start."""
        return self.tool.latest.message.position - START if self.tool.latest else np.zeros(3)

    def mode(self) -> str:
        return self.gate.latest.message.mode if self.gate.latest else ""

    def says(self) -> str:
        return f"{self.mode()}, {self.status.latest.message.reason if self.status.latest else 'nothing'}"


@pytest.fixture(scope="module")
def robots(shared_router: Router, tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Robot]]:
    with ExitStack() as open_:
        start = open_.enter_context(_processes(tmp_path_factory.mktemp("robots")))
        made = {name: Robot(name, shared_router.endpoint, start) for name in DIRECTIONS}
        for robot in made.values():
            open_.enter_context(closing(robot.bus))
        for name, robot in made.items():
            eventually(lambda robot=robot: programs.tared(robot.client), PATIENCE, f"{name} is tared")
        yield made


def go_on(robots: list[Robot]) -> None:
    """Wait until each has gone on, and along its own direction only."""
    begun = [robot.gone() for robot in robots]

    def further() -> bool:
        for robot in robots:
            robot.aim()
        return all(
            float((robot.gone() - before) @ robot.direction) > 0.02 for robot, before in zip(robots, begun, strict=True)
        )

    eventually(further, PATIENCE, lambda: "; ".join(robot.says() for robot in robots))
    for robot in robots:
        aside = robot.gone() - (robot.gone() @ robot.direction) * robot.direction
        assert np.linalg.norm(aside) < 0.02 and robot.tool.rejected == 0


def test_what_befalls_one_does_not_touch_the_others(robots: dict[str, Robot]) -> None:
    first, second, *others = robots.values()
    go_on([first, second, *others])

    first.client.publish(STOP, Stop(True, "test"))
    eventually(lambda: first.mode() == "stopped", PATIENCE, first.says)
    go_on([second, *others])

    second.controller.kill()
    eventually(lambda: second.mode() == "holding", PATIENCE, second.says)
    go_on(others)
    assert first.mode() == "stopped"
    assert not any("stop" in robot.says() for robot in (second, *others))
