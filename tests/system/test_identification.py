"""Simulated robot, wrench service and controller in one process: the gripper's weight is found by moving it."""

from __future__ import annotations

import numpy as np
import pytest

from services.controller.controller import Controller
from services.controller.parameters import ControllerParameters
from services.sim.parameters import SimParameters
from services.sim.simulator import Simulator
from services.wrench.parameters import WrenchParameters
from services.wrench.wrench import Wrench
from shared.loop.stack import Stack
from shared.messages import ControlTarget, EndEffector
from shared.spatial import quaternion_from_rpy
from shared.topics import CONTROL_TARGET, SIM_COMMAND, STATE_EE, WRENCH_EXTERNAL, WRENCH_IDENTIFY, WRENCH_TARE

GRIPPER_MASS = 0.60266 + 2 * 0.10998
BIAS = (1.0, -2.0, 3.0, 0.1, -0.05, 0.02)
TILTS = ((0.0, 0.0), (0.3, -0.3), (0.0, -0.45), (-0.3, -0.3), (-0.4, 0.0))


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_gripper_and_bias_are_identified_by_tilting_and_a_bag_is_weighed_rightly_then() -> None:
    stack = Stack()
    clock = stack.scheduler.clock
    stack.add(Simulator(SimParameters.of({"scene": "load", "ft_bias": BIAS})))
    stack.add(Wrench(WrenchParameters()))
    stack.add(Controller(ControllerParameters(), clock.now_ns))
    tool, wrench = stack.client.watch(STATE_EE), stack.client.watch(WRENCH_EXTERNAL)
    stack.run(1.0)
    stack.client.ask(WRENCH_TARE, {"duration": 1.0})
    stack.client.ask(WRENCH_IDENTIFY, {"action": "start"})
    assert tool.latest is not None
    position = tool.latest.message.position
    for roll, pitch in TILTS:
        orientation = quaternion_from_rpy(roll, pitch, 0.0)
        stack.client.publish(CONTROL_TARGET, ControlTarget(position, orientation, [60.0] * 3, [15.0] * 3))
        stack.run(12.0, done=lambda wanted=orientation: _arrived(tool.latest.message, wanted))
        stack.client.ask(WRENCH_IDENTIFY, {"action": "add"}, timeout=3.0)
    result = stack.client.ask(WRENCH_IDENTIFY, {"action": "solve"})
    sigma = result["sigma"]
    assert abs(result["mass"] - GRIPPER_MASS) < 4 * sigma[0] < 0.02
    found = np.array(result["force_bias"] + result["torque_bias"])
    assert np.all(np.abs(found - BIAS) < 4 * np.array(sigma[4:]))
    assert np.all(np.array(sigma[4:7]) < 0.05)

    stack.client.ask(SIM_COMMAND, {"command": "load", "mass": 1.0})
    stack.run(4.0)
    assert wrench.latest is not None
    reading = wrench.latest.message
    assert reading.compensation == "payload"
    assert abs(reading.force[2] + 9.81) < reading.error_bound[2] < 1.0


def _arrived(tool: EndEffector, wanted: np.ndarray) -> bool:
    still = np.linalg.norm(tool.linear) < 2e-3 and np.linalg.norm(tool.angular) < 2e-3
    return bool(still and abs(tool.orientation @ wanted) > np.cos(0.05))
