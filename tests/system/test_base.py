"""Wrench service, base service and a robot in one process: a push at the tool moves the base, as far as it should."""

from __future__ import annotations

import numpy as np
import pytest

from services.base.base import Base
from services.base.parameters import BaseParameters
from services.mock.parameters import MockParameters
from services.mock.robot import MockRobot
from services.wrench.parameters import WrenchParameters
from services.wrench.wrench import Wrench
from shared.clock import nanoseconds
from shared.loop.stack import Stack
from shared.messages import Enable, Stop
from shared.topics import BASE_ENABLE, BASE_STATUS, STOP, WRENCH_EXTERNAL, WRENCH_TARE


class Pushed:
    """A differential robot whose tool rests, tared, with a task that enables the base."""

    def __init__(self) -> None:
        self.stack = Stack()
        self.robot = MockRobot(MockParameters(still=True))
        for service in (self.robot, Wrench(WrenchParameters()), Base(BaseParameters())):
            self.stack.add(service)
        self.wrench = self.stack.client.watch(WRENCH_EXTERNAL)
        self.status = self.stack.client.watch(BASE_STATUS)
        self.stack.run(0.5)
        self.stack.client.ask(WRENCH_TARE, {"duration": 0.5})
        self._enable()

    def _enable(self) -> None:
        self.stack.client.publish(BASE_ENABLE, Enable(True))
        self.stack.scheduler.at(self.stack.scheduler.clock.now_ns() + nanoseconds(0.2), self._enable)

    def push(self, force: tuple[float, float, float], duration: float) -> None:
        self.robot.sensors.wrench = np.array((*force, 0.0, 0.0, 0.0))
        self.stack.run(duration)


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
