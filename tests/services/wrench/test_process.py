"""The wrench service as a process over a real router: what it alone keeps. What all keep is in ``tests/promises``."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from shared.messages import ExternalWrench
from shared.parameters import Refused
from shared.topics import SENSOR_FT, WRENCH_EXTERNAL, WRENCH_TARE
from shared.wire.subscription import Received
from tests.conftest import Router, StartProcess
from tests.services.wrench.sensor import LEVEL, Sensor
from tests.support.processes import Process
from tests.support.stand_in import StandIn
from tests.support.wait import eventually

pytestmark = pytest.mark.processes


class Robot(StandIn):
    """Publishes made-up samples, and collects what the wrench service makes of them."""

    def __init__(self, endpoint: str) -> None:
        super().__init__(endpoint, "wrench")
        self.sensor = Sensor()
        self.external = np.zeros(6)
        self.received: list[Received[ExternalWrench]] = self.hear(WRENCH_EXTERNAL)

    def turn(self, number: int) -> None:
        self.client.publish(SENSOR_FT, self.sensor.sample(LEVEL, self.external))

    @property
    def last(self) -> ExternalWrench | None:
        """The newest valid wrench."""
        return next((r.message for r in reversed(self.received) if r.header.valid), None)

    def tared(self) -> dict:
        """The answer to a tare; a busy machine may spoil one, not every one."""

        def attempt() -> dict | None:
            try:
                return self.client.ask(WRENCH_TARE, {"duration": 0.3}, timeout=10.0)
            except Refused as refusal:
                assert "sensor/ft" in str(refusal)
                return None

        eventually(lambda: self.last, 20.0, "a valid wrench")
        answer = eventually(attempt, 60.0, "a tare")
        eventually(lambda: self.last.compensation == "tare", message="the tare in force")
        return answer


@pytest.fixture
def robot(shared_router: Router) -> Iterator[Robot]:
    with Robot(shared_router.endpoint) as robot:
        yield robot


def launch(router: Router, start: StartProcess, state: Path) -> Process:
    return start("services.wrench", "--connect", router.endpoint, environment={"XDG_STATE_HOME": str(state)})


def test_a_tare_over_the_router_outlives_the_process(
    robot: Robot, shared_router: Router, start: StartProcess, tmp_path: Path
) -> None:
    first = launch(shared_router, start, tmp_path)
    assert robot.tared()["samples"] >= 10
    robot.external = np.array((0.0, 0.0, -9.81, 0.0, 0.0, 0.0))
    eventually(
        lambda: abs(robot.last.force[2] + 9.81) < robot.last.error_bound[2],
        message="one hanging kilogram reads -9.81 N",
    )
    first.kill()
    robot.received.clear()
    launch(shared_router, start, tmp_path)
    eventually(lambda: robot.last, 20.0, "a valid wrench of the second process")
    for received in robot.received:
        if received.header.valid:
            assert received.message.compensation == "tare"
            assert np.all(np.abs(received.message.force - robot.external[:3]) <= 1.0)
