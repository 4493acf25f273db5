"""What ``tests/contract`` does not see of the mock robot: it can stand still, and each of its rates is a choice."""

from __future__ import annotations

import pytest

from services.mock.parameters import MockParameters
from services.mock.robot import MockRobot
from shared.loop.stack import Stack
from shared.messages import EndEffector, TwistCommand
from shared.topics import COMMAND_EE_TWIST, SENSOR_FT, STATE_EE


@pytest.mark.parametrize("still", [True, False])
def test_a_still_robot_is_let_move_by_its_gate_and_stays(still: bool) -> None:
    stack, robot = Stack(), MockRobot(MockParameters(still=still))
    stack.add(robot)
    told: list[EndEffector] = []
    stack.client.watch(STATE_EE, lambda received: told.append(received.message))
    for _ in range(20):
        stack.client.publish(COMMAND_EE_TWIST, TwistCommand((0.1, 0.0, 0.0), (0.0, 0.0, 0.2), 0.1))
        stack.run(0.02)
    assert robot.side.mode == "ready" and robot.motors.twist[0] == pytest.approx(0.1)
    assert (told[-1].linear == 0.0).all() == (told[-1].angular == 0.0).all() == still
    assert (told[-1].position == told[0].position).all() == still
    assert (told[-1].orientation == told[0].orientation).all() == still


def test_sample_pose_and_gate_have_rates_of_their_own() -> None:
    stack, robot = Stack(), MockRobot(MockParameters(rate=100.0, pose_rate=50.0, steps=5))
    stack.add(robot)
    samples, poses = stack.client.watch(SENSOR_FT), stack.client.watch(STATE_EE)
    stack.run(2.0)
    assert robot.wiring.driver == pytest.approx(0.002)
    assert samples.accepted == pytest.approx(200, abs=1) and poses.accepted == pytest.approx(100, abs=1)
