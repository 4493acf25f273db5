"""The robot between the bus and its hardware: a bridge's ``step`` is this one's, line by line."""

from __future__ import annotations

from services.mock.commands import Motors
from services.mock.parameters import MockParameters
from services.mock.sensors import Sensors
from shared.faults import Fault
from shared.robot import tiago
from shared.robot.gate import GateLimits
from shared.robot.side import RobotSide
from shared.service import Inputs, Output, Service, Wiring

MAX_ACCELERATION, MAX_ANGULAR_ACCELERATION = 2.0, 4.0  # [m/s2, rad/s2] of the tool's gate


class MockRobot(Service[MockParameters]):
    """Moves exactly as its gate lets it.

    Attributes:
        side: the gate, with the commands in front of it and ``state/robot`` behind it.
        motors: where tool, base and fingers are, and how they move.
        sensors: what is told of it; ``sensors.wrench`` (6,) [N, Nm] pushes the tool and may be set at any time.
    """

    def __init__(self, parameters: MockParameters) -> None:
        super().__init__(parameters)
        self.side = RobotSide(
            GateLimits(parameters.max_linear, parameters.max_angular, MAX_ACCELERATION, MAX_ANGULAR_ACCELERATION),
            parameters.base_type,
            simulated=True,
            base=tiago.BASES[parameters.base_type],
            gripper=tiago.GRIPPER_RANGES,
            head=tiago.HEAD_RANGES,
            require_enable=parameters.require_enable,
        )
        self.motors = Motors(parameters)
        self.sensors = Sensors(parameters, self.motors)
        self.wiring = Wiring(
            name="mock",
            driver=1.0 / (parameters.rate * parameters.steps),
            optional=RobotSide.INPUTS,
            # A late step is no reason to stand still: the gate watches over the commands' age.
            overrun_share=1.0,
        )

    def step(self, inputs: Inputs, dt: float) -> list[Output]:
        """Carry out for ``dt`` [s] what the gate lets through, then tell where that has led."""
        self.side.take(inputs)
        self.motors.carry_out(self.side, dt)
        return [*self.sensors.read(), *self.side.report(dt)]

    def brake(self, fault: Fault, dt: float) -> list[Output]:
        """Nothing moves while the loop does not work."""
        self.motors.stay()
        return self.side.hold(fault.text)
