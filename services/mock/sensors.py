"""Messages of the hardware's state: here of the motors' and of a wrench that somebody sets."""

from __future__ import annotations

import numpy as np

from services.mock.commands import Motors
from services.mock.parameters import MockParameters
from shared.messages import BaseState, EndEffector, FtSample, GripperState, JointState
from shared.robot.tiago import JOINTS
from shared.service import Output
from shared.spatial import Array, quaternion, wrench_about
from shared.topics import SENSOR_FT, STATE_BASE, STATE_EE, STATE_GRIPPER, STATE_JOINTS

TOOL_IN_SENSOR = np.array((0.2, 0.0, 0.0))  # [m] from the sensor's origin, in its axes, which are the tool's
_NAMES = tuple(JOINTS)
_NO_MOTION = np.zeros(6)


class Sensors:
    """Wrist sensor, joints, odometry and fingers, each at its rate.

    Attributes:
        wrench: that acts on the tool's origin (6,) [N, Nm], base axes.
    """

    def __init__(self, parameters: MockParameters, motors: Motors) -> None:
        self.wrench: Array = np.array(parameters.wrench)
        self._motors = motors
        self._noise = parameters.noise
        self._random = np.random.default_rng(0)
        self._step_rate = parameters.rate * parameters.steps
        # The pose goes first: whoever is driven by the sample finds it there.
        self._all = (
            (STATE_EE, parameters.pose_rate, self._tool),
            (SENSOR_FT, parameters.rate, self._sample),
            (STATE_JOINTS, STATE_JOINTS.rate, self._joints),
            (STATE_BASE, STATE_BASE.rate, self._base),
            (STATE_GRIPPER, STATE_GRIPPER.rate, self._gripper),
        )
        self._steps = 0

    def read(self) -> list[Output]:
        """The messages that are due in this step."""
        self._steps += 1
        return [Output(topic, measure()) for topic, rate, measure in self._all if self._due(rate)]

    def _due(self, rate: float) -> bool:
        return self._steps % max(1, round(self._step_rate / rate)) == 0

    def _tool(self) -> EndEffector:
        motors = self._motors
        twist = _NO_MOTION if motors.still else motors.twist
        return EndEffector(motors.position, quaternion(motors.rotation), twist[:3], twist[3:])

    def _sample(self) -> FtSample:
        in_sensor = np.concatenate((self.wrench[:3] @ self._motors.rotation, self.wrench[3:] @ self._motors.rotation))
        reading = wrench_about(in_sensor, TOOL_IN_SENSOR) + self._random.normal(0.0, self._noise)
        return FtSample(reading[:3], reading[3:], quaternion(self._motors.rotation), TOOL_IN_SENSOR, False)

    def _joints(self) -> JointState:
        zeros = np.zeros(len(_NAMES))
        return JointState(_NAMES, zeros, zeros, zeros)

    def _base(self) -> BaseState:
        return BaseState(self._motors.base[:2], self._motors.base[2], self._motors.base_velocity)

    def _gripper(self) -> GripperState:
        return GripperState(self._motors.opening, 0.0, False)
