"""How many times faster than real time the simulated robot computes, with nothing around it but bags, on one core."""

from __future__ import annotations

import time

from benchmarks.table import Row, at_least, shown
from services.sim.parameters import SimParameters
from services.sim.simulator import Simulator
from shared import topics
from shared.clock import nanoseconds
from shared.loop.stack import Stack
from shared.messages import TwistCommand

COMMAND = "python -m benchmarks sim_speed"
PERIOD = 0.01
"""Time [s] between two commands."""
SPEED = 0.05
"""Speed [m/s] at which the tool goes down and up again."""
LEG = 4.0
"""Time [s] of each way."""


def ratio(duration: float, moving: bool) -> float:
    """Simulated time per processor time with a bag hung from the tool, standing still or moving all the time."""
    stack = Stack()
    stack.add(Simulator(SimParameters.of({"scene": "load"})))
    stack.run(0.5)
    stack.client.ask(topics.SIM_COMMAND, {"command": "load", "mass": 2.0})
    stack.run(0.5)
    began = time.process_time()
    for step in range(round(duration / PERIOD)):
        if moving:
            sign = -1.0 if (step * PERIOD) % (2 * LEG) < LEG else 1.0
            stack.client.publish(
                topics.COMMAND_EE_TWIST, TwistCommand((0.0, 0.0, sign * SPEED), (0.0, 0.0, 0.0), 2 * PERIOD)
            )
        stack.scheduler.run_until(stack.scheduler.clock.now_ns() + nanoseconds(PERIOD))
    return duration / (time.process_time() - began)


def rows(quick: bool) -> list[Row]:
    """The rows of this benchmark."""
    duration = 4.0 if quick else 4 * LEG
    return [
        at_least("services/sim without camera, tool moving, times real time", ratio(duration, True), 3.0, "", COMMAND),
        shown("the same, tool holding a bag", ratio(duration, False), "", COMMAND),
    ]
