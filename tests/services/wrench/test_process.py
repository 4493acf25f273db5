"""The wrench service as a process over a real router: what it alone keeps. What all keep is in ``tests/promises``."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from shared.parameters import Refused
from shared.topics import SENSOR_FT, WRENCH_EXTERNAL, WRENCH_IDENTIFY, WRENCH_TARE, Query
from tests.conftest import Router, StartProcess
from tests.services.wrench.sensor import LEVEL, TILTED, Sensor
from tests.support.processes import Process
from tests.support.stand_in import StandIn
from tests.support.wait import eventually


def launched(router: Router, start: StartProcess, folder: Path) -> Process:
    connect = ("--connect", router.endpoint)
    return start("services.wrench", *connect, environment={"XDG_STATE_HOME": str(folder)})


def measured(robot: StandIn, query: Query, request: dict) -> dict | None:
    """A busy machine may spoil a measurement, not every one."""
    try:
        return robot.client.ask(query, request, timeout=10.0)
    except Refused as refusal:
        assert "sensor/ft" in str(refusal) or "late" in str(refusal)
        return None


@pytest.mark.processes
def test_a_tare_over_the_router_outlives_the_process(
    shared_router: Router, start: StartProcess, tmp_path: Path
) -> None:
    sensor, external = Sensor(), np.zeros(6)

    def launch() -> Process:
        return launched(shared_router, start, tmp_path)

    def tared() -> dict | None:
        return measured(robot, WRENCH_TARE, {"duration": 0.3})

    def hangs() -> bool:
        newest = wrenches[-1].message
        bound = newest.error_bound[2]
        return newest.compensation == "tare" and abs(newest.force[2] + 9.81) < bound

    says = lambda number: [(SENSOR_FT, sensor.sample(LEVEL, external))]  # noqa: E731
    with StandIn(shared_router.endpoint, "wrench", says) as robot:
        wrenches = robot.hear(WRENCH_EXTERNAL)
        first = launch()
        eventually(lambda: wrenches, 20.0, "a wrench")
        assert eventually(tared, 60.0, "a tare")["samples"] >= 10
        external[2] = -9.81
        eventually(hangs, message="one hanging kilogram reads -9.81 N")
        first.kill()
        wrenches.clear()
        launch()
        eventually(lambda: any(r.header.valid for r in wrenches), 20.0, "a valid wrench of the second process")
        for message in (received.message for received in tuple(wrenches) if received.header.valid):
            assert message.compensation == "tare"
            assert np.all(np.abs(message.force - external[:3]) <= 1.0)


@pytest.mark.processes
def test_an_identified_payload_outlives_the_robot_process_and_then_this_one(
    shared_router: Router, start: StartProcess, tmp_path: Path
) -> None:
    sensor, rotation = Sensor(), LEVEL.copy()
    says = lambda number: [(SENSOR_FT, sensor.sample(rotation))]  # noqa: E731
    first = launched(shared_router, start, tmp_path)
    with StandIn(shared_router.endpoint, "wrench", says) as robot:
        wrenches = robot.hear(WRENCH_EXTERNAL)
        eventually(lambda: any(r.header.valid for r in wrenches), 20.0, "a valid wrench")
        robot.client.ask(WRENCH_IDENTIFY, {"action": "start"}, timeout=10.0)
        for turned in TILTED:
            rotation[:] = turned
            eventually(lambda: measured(robot, WRENCH_IDENTIFY, {"action": "add", "duration": 0.3}), 60.0, "a pose")
        assert robot.client.ask(WRENCH_IDENTIFY, {"action": "solve"}, timeout=10.0)["poses"] >= len(TILTED)
    with StandIn(shared_router.endpoint, "wrench", says) as robot:
        wrenches = robot.hear(WRENCH_EXTERNAL)
        eventually(lambda: any(r.message.zero_age == -1.0 for r in wrenches), 20.0, "the robot's other run")
        first.kill()
        wrenches.clear()
        launched(shared_router, start, tmp_path)
        eventually(lambda: any(r.header.valid for r in wrenches), 20.0, "a valid wrench of the second process")
        newest = wrenches[-1].message
        assert (newest.compensation, newest.zero_age) == ("payload", -1.0)
        assert np.all(np.abs(newest.force) <= newest.error_bound[:3])
