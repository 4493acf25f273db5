"""Wrench service, base service and a robot together: a push at the tool moves the base, an error of the sensor none."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from services.base.base import Base
from services.base.parameters import BaseParameters
from services.mock.parameters import MockParameters
from services.mock.robot import MockRobot
from services.mock.sensors import TOOL_IN_SENSOR
from services.wrench.compensation import transport
from services.wrench.identification import IdentifiedPayload
from services.wrench.parameters import WrenchParameters
from services.wrench.storage import save_payload
from services.wrench.wrench import Wrench
from shared.clock import nanoseconds
from shared.loop.stack import Stack
from shared.messages import Enable, Stop
from shared.spatial import Array
from shared.topics import BASE_ENABLE, BASE_STATUS, STOP, WRENCH_EXTERNAL, WRENCH_TARE


class Pushed:
    """A robot whose tool rests, tared, with a task that enables the base."""

    def __init__(self, base: str = "differential", tare: bool = True, **wrench: Any) -> None:
        self.stack = Stack()
        self.robot = MockRobot(MockParameters(still=True, base_type=base))
        for service in (self.robot, Wrench(WrenchParameters.of(wrench)), Base(BaseParameters())):
            self.stack.add(service)
        self.wrench = self.stack.client.watch(WRENCH_EXTERNAL)
        self.status = self.stack.client.watch(BASE_STATUS)
        self.stack.run(0.5)
        if tare:
            self.stack.client.ask(WRENCH_TARE, {"duration": 0.5})
        self._enable()

    def _enable(self) -> None:
        self.stack.client.publish(BASE_ENABLE, Enable(True))
        self.stack.scheduler.at(self.stack.scheduler.clock.now_ns() + nanoseconds(0.2), self._enable)

    def push(self, force: tuple[float, float, float], duration: float) -> None:
        self.robot.sensors.wrench = np.array((*force, 0.0, 0.0, 0.0))
        self.stack.run(duration)

    def bias(self, bias: Array, duration: float) -> None:
        """The sensor reads so much (6,) [N, Nm] too much, sensor axes."""
        self.robot.sensors.wrench = transport(self.robot.motors.rotation, TOOL_IN_SENSOR) @ bias
        self.stack.run(duration)

    @property
    def rolled(self) -> bool:
        """Whether the base has moved."""
        assert self.status.latest is not None and self.status.latest.message.state == "following"
        return bool(self.robot.motors.base.any())


DRIFT = np.array((0.3, 1.4, 4.0, 0.01, 0.02, 0.03))
"""[N, Nm] What the users of a UR5e saw within five minutes of its start; here within twenty seconds."""


@pytest.mark.parametrize("declared", [True, False])
def test_a_drifting_sensor_rolls_no_base_if_the_drift_is_declared(declared: bool) -> None:
    rig = Pushed("omni", zero_drift=(3.0 * DRIFT).tolist() if declared else [0.0] * 6)
    for share in np.linspace(0.0, 1.0, 101)[1:]:
        rig.bias(share * DRIFT, 0.2)
    assert rig.rolled is not declared, "what is not declared is not promised"


def test_last_weeks_file_rolls_no_base(tmp_path: Path) -> None:
    zero3, zero6 = np.zeros(3), np.zeros(6)
    week_ago = np.array((-1.0, 2.0, 0.5))
    sigma = (1e-4, zero3, zero3, zero3)
    save_payload(
        tmp_path / "payload.toml",
        IdentifiedPayload(1e-3, zero3, week_ago, zero3, *sigma, zero6, zero6, zero6, condition=3.0, poses=5),
    )
    rig = Pushed("omni", tare=False, payload=str(tmp_path / "payload.toml"))
    rig.bias(np.array((3.0, -1.0, 1.5, 0.1, -0.3, 0.4)), 10.0)
    assert not rig.rolled
    rig.stack.client.ask(WRENCH_TARE, {"duration": 0.5})
    rig.stack.run(5.0)
    assert not rig.rolled


def test_a_push_moves_the_base_and_its_end_lets_it_coast_to_rest() -> None:
    rig = Pushed()
    rig.stack.run(1.0)
    assert not rig.robot.motors.base.any()
    rig.push((7.0, 0.0, -9.0), 3.0)
    assert rig.wrench.latest is not None and rig.status.latest is not None
    band = max(1.0, rig.wrench.latest.message.error_bound[0])
    speed = (7.0 - band) / 20.0
    assert rig.robot.motors.base_velocity[0] == pytest.approx(speed, abs=0.02)
    torque = -rig.robot.motors.position[1] * 7.0
    assert rig.status.latest.message.wrench == pytest.approx((7.0, 0.0, torque), abs=0.3)
    assert rig.robot.motors.base_velocity[2] > 0.0, "a pull to the front at the right turns left"
    rig.push((0.0, 0.0, 0.0), 5.0)
    assert np.abs(rig.robot.motors.base_velocity).max() < 1e-3
    assert rig.status.latest.message.state == "following"


def test_a_stop_brakes_the_base_and_the_service_begins_from_rest_after_it() -> None:
    rig = Pushed()
    rig.push((8.0, 0.0, 0.0), 2.0)
    assert rig.robot.motors.base_velocity[0] > 0.1
    rig.stack.client.publish(STOP, Stop(True, "red button"))
    rig.stack.run(2.0)
    assert rig.status.latest is not None
    assert not rig.robot.motors.base_velocity.any() and rig.status.latest.message.state == "off"
    rig.stack.client.publish(STOP, Stop(False))
    rig.stack.run(0.03)
    assert 0.0 <= rig.robot.motors.base_velocity[0] <= 0.7 * 0.03
    rig.stack.run(2.0)
    assert rig.robot.motors.base_velocity[0] > 0.1
