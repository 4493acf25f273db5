"""A robot without physics: it speaks the robot's side of the contract and moves exactly as its gate lets it.

A service like any other, so it runs in the in-process stack (``stack.add(StubRobot(StubParameters()))``) as well as in
a process of its own (``python -m tests.support.stub_robot --connect ... --set rate=500.0``).
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any, Literal

import numpy as np

from shared import topics
from shared.faults import Fault
from shared.loop.process import run
from shared.messages import BaseState, EndEffector, FtSample, GripperState, JointState
from shared.parameters import Parameters, Refused, Vector3, Vector6, parameter
from shared.robot.base_gate import BaseLimits
from shared.robot.gate import GateLimits
from shared.robot.side import RobotSide
from shared.service import Inputs, Output, Wiring
from shared.spatial import Array, quaternion, rotation_from_vector, wrench_about
from shared.topics import Query

_SENSOR_IN_TOOL = np.array((-0.2, 0.0, 0.0))
"""Origin of the sensor in tool axes [m]; both frames have the same axes."""
_JOINTS = tuple(f"arm_right_{number}_joint" for number in range(1, 8))
_BASE = {
    "differential": BaseLimits(0.5, 0.5, 0.0, 0.5, 10.0, 20.0),
    "omni": BaseLimits(0.5, 0.5, 0.5, 0.5, 10.0, 20.0),
}
_START = (0.5, -0.3, 1.0)


class StubParameters(Parameters):
    """What the stub robot pretends."""

    rate: float = parameter(100.0, unit="Hz", minimum=30.0, maximum=1000.0, doc="sensor/ft")
    joint_rate: float = parameter(
        1000.0, unit="Hz", minimum=20.0, maximum=1000.0, doc="state/ee, at most rate"
    )
    ticks: int = parameter(
        1, unit="", minimum=1, maximum=100, doc="ticks of the gate per sample of sensor/ft"
    )
    still: bool = parameter(
        False, unit="", doc="whether the tool stays where it is, whatever the gate lets through"
    )
    base_type: Literal["differential", "omni"] = parameter("differential", unit="", doc="kind of base")
    max_linear: float = parameter(0.5, unit="m/s", minimum=0.01, maximum=2.0, doc="gate, linear")
    max_angular: float = parameter(1.0, unit="rad/s", minimum=0.01, maximum=3.0, doc="gate, angular")
    load: Vector6 = parameter((0.0,) * 6, unit="N, Nm", doc="wrench at the tool, base axes")
    noise: Vector6 = parameter((0.02,) * 3 + (0.002,) * 3, unit="N, Nm", minimum=0.0, doc="deviation")
    position: Vector3 = parameter(_START, unit="m", doc="of the tool at the start")


class StubRobot:
    """Integrates the twist that its gate lets through; ``load`` (6,) [N, Nm] may be changed at any time."""

    max_delay = 0.2

    def __init__(self, parameters: StubParameters) -> None:
        self.parameters: Parameters = parameters
        self._settings = parameters
        limits = GateLimits(parameters.max_linear, parameters.max_angular, 2.0, 4.0)
        self.side = RobotSide(
            limits,
            parameters.base_type,
            simulated=False,
            base=_BASE[parameters.base_type],
            gripper={"opening": (0.0, 0.08), "effort": (0.0, 16.0)},
            head={"pan": (-1.3, 1.3), "tilt": (-1.0, 0.7)},
        )
        self.load: Array = np.array(parameters.load)
        self.position: Array = np.array(parameters.position)
        self.rotation: Array = np.eye(3)
        self.base: Array = np.zeros(3)
        self.base_velocity: Array = np.zeros(3)
        self.opening = 0.08
        self.twist: Array = np.zeros(6)
        self._random = np.random.default_rng(0)
        self._ticks = 0
        self.wiring = Wiring(
            name="robot",
            driver=1.0 / (parameters.rate * parameters.ticks),
            optional=RobotSide.INPUTS,
            overrun_share=1.0,
        )

    @property
    def executes(self) -> bool:
        """Whether the gate lets fresh, valid commands through."""
        return self.side.mode == "ready"

    def step(self, inputs: Inputs, dt: float) -> list[Output]:
        """Execute for ``dt`` [s] what the gate lets through, then say where that led."""
        self.side.take(inputs)
        if self.side.gripper is not None:
            self.opening = self.side.gripper.opening
        self._move(dt, self.side.advance_base(dt))
        self._ticks += 1
        return [*self._outputs(), *self.side.report(dt)]

    def brake(self, fault: Fault, dt: float) -> list[Output]:
        """Nothing moves while the loop is not working."""
        return self.side.hold(fault.text)

    def query(self, query: Query, request: dict[str, Any], reply: Callable[[dict[str, Any]], None]) -> None:
        """Refuse: this robot answers no queries."""
        raise Refused(f"{query.key}: the stub robot has nothing to command")

    def apply(self, parameters: Parameters) -> None:
        """The parameters hold for the whole run."""
        self.parameters = parameters

    def notes(self) -> str:
        """Nothing to tell."""
        return ""

    def _move(self, dt: float, base_velocity: Array) -> None:
        self.twist = self.side.advance(dt)
        if not self._settings.still:
            self.position = self.position + dt * self.twist[:3]
        if self.twist[3:].any() and not self._settings.still:
            self.rotation = rotation_from_vector(dt * self.twist[3:]) @ self.rotation
        cosine, sine = np.cos(self.base[2]), np.sin(self.base[2])
        vx, vy, wz = base_velocity
        self.base = self.base + dt * np.array((cosine * vx - sine * vy, sine * vx + cosine * vy, wz))
        self.base_velocity = base_velocity

    def _due(self, rate: float) -> bool:
        every = max(1, round(self._settings.rate * self._settings.ticks / rate))
        return self._ticks % every == 0

    def _outputs(self) -> list[Output]:
        outputs = []
        if self._due(self._settings.joint_rate):
            twist = np.zeros(6) if self._settings.still else self.twist
            tool = EndEffector(self.position, quaternion(self.rotation), twist[:3], twist[3:])
            outputs.append(Output(topics.STATE_EE, tool))
        # The pose goes first: whoever is driven by the sample finds it there.
        if self._due(self._settings.rate):
            outputs.append(Output(topics.SENSOR_FT, self._ft_sample()))
        if self._due(topics.STATE_JOINTS.rate):
            zeros = np.zeros(len(_JOINTS))
            outputs.append(Output(topics.STATE_JOINTS, JointState(_JOINTS, zeros, zeros, zeros)))
        if self._due(topics.STATE_BASE.rate):
            state = BaseState(self.base[:2], self.base[2], self.base_velocity)
            outputs.append(Output(topics.STATE_BASE, state))
        if self._due(topics.STATE_GRIPPER.rate):
            outputs.append(Output(topics.STATE_GRIPPER, GripperState(self.opening, 0.0, False)))
        return outputs

    def _ft_sample(self) -> FtSample:
        # The tool's origin from the sensor's, about which the sensor reads.
        offset = -_SENSOR_IN_TOOL
        to_sensor = self.rotation.T
        in_sensor = np.concatenate((to_sensor @ self.load[:3], to_sensor @ self.load[3:]))
        wrench = wrench_about(in_sensor, offset)
        wrench = wrench + self._random.normal(0.0, self._settings.noise)
        return FtSample(wrench[:3], wrench[3:], quaternion(self.rotation), offset, False)


if __name__ == "__main__":
    sys.exit(run(StubRobot, StubParameters, "robot"))
