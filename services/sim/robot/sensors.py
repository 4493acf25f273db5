"""The robot's sensors: what wrist and joints make of what is true."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pinocchio as pin

from services.sim.robot.arm import Arm
from services.sim.robot.gripper import Gripper
from services.sim.robot.head import Head
from services.sim.robot.kinematics import arm_kinematics, full_model, home
from services.sim.robot.sensor_line import SensorLine
from shared.messages import EndEffector, JointState
from shared.robot.kinematics import joint_names
from shared.robot.tiago import CHAIN, FINGERS, HEAD, SENSOR_RANGE
from shared.spatial import Array, quaternion

DITHER = 1e-6
"""[N, Nm] Least standard deviation of the noise: no real sensor repeats a value to the last bit, and who watches one
takes an axis that does for stuck."""


class ForceTorqueSensor:
    """The wrist's force-torque sensor: it adds a drifting bias and white noise, and saturates.

    Args:
        noise: standard deviation per axis (6,) [N, Nm]; below ``DITHER`` it is that.
        bias: error per axis at the start (6,) [N, Nm].
        drift: of the bias (6,) [N, Nm per minute].
        seed: of the noise; the same seed gives the same readings.
    """

    def __init__(self, noise: Sequence[float], bias: Sequence[float], drift: Sequence[float], seed: int) -> None:
        self._noise = np.maximum(noise, DITHER)
        self._bias = np.array(bias)
        self._drift = np.array(drift) / 60.0
        self._random = np.random.default_rng(seed)

    def read(self, wrench: Array, time: float) -> tuple[Array, bool]:
        """One reading (6,) [N, Nm] of a true wrench (6,), both in sensor axes, and whether an axis is saturated.

        Args:
            wrench: true.
            time: since the start [s].
        """
        reading = wrench + self._bias + self._drift * time + self._noise * self._random.standard_normal(6)
        clipped = np.minimum(np.maximum(reading, -SENSOR_RANGE), SENSOR_RANGE)
        return clipped, clipped.tolist() != reading.tolist()


class JointSensors:
    """The joints' encoders, and what the robot computes from them.

    Joints that this simulation does not drive (left arm, left gripper) are reported where they are held, with the
    effort that their weight takes.

    Args:
        arm, head, gripper: that move.
        start: positions [m, rad] of all joints at the start, by name; those not named are at zero.
        line: that the encoders' values take.
    """

    def __init__(self, arm: Arm, head: Head, gripper: Gripper, start: Mapping[str, float], line: SensorLine) -> None:
        self._physics = arm.physics
        self._head, self._gripper = head, gripper
        self._line = line
        self._kinematics = arm_kinematics()
        model = full_model()
        self._names = joint_names(model)
        self._position = home(model, start)
        self._effort = pin.computeGeneralizedGravity(model, model.createData(), self._position)
        self._at_chain = np.array([self._names.index(name) for name in CHAIN])
        self._at_head = [self._names.index(name) for name in HEAD]
        self._at_fingers = [self._names.index(name) for name in FINGERS]

    def measure(self) -> tuple[JointState, EndEffector]:
        """Joint states and the tool's pose and twist, as the encoders have them."""
        physics = self._physics
        position, velocity, effort = self._line.stick(lambda: (physics.position, physics.velocity, physics.effort()))
        position = self._line.shift(position)
        all_positions, all_velocities = self._position.copy(), np.zeros(len(self._names))
        all_efforts = self._effort.copy()
        all_positions[self._at_chain] = position
        all_positions[self._at_fingers] = self._gripper.left, self._gripper.right
        all_positions[self._at_head] = self._head.position
        all_velocities[self._at_chain] = velocity
        all_efforts[self._at_chain] = effort
        self._kinematics.update(position)
        tool, rotation = self._kinematics.tool()
        twist = self._kinematics.jacobian().dot(velocity)
        return (
            JointState(self._names, all_positions, all_velocities, all_efforts),
            EndEffector(tool, quaternion(rotation), twist[:3], twist[3:]),
        )
