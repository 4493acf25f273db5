"""What the robot tells about itself: messages made of the arm's state."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from services.sim.robot.kinematics import Kinematics, full_model, home, joint_names
from services.sim.robot.sensor_line import SensorLine
from services.sim.scene.world import World
from shared.messages import EndEffector, JointState
from shared.robot.tiago import CHAIN, FINGERS, HEAD
from shared.spatial import quaternion


class JointSensors:
    """The joints' encoders, and what the robot computes from them.

    Joints that this simulation does not drive (left arm, left gripper) are reported where they are held, with the
    effort that their weight takes.
    """

    def __init__(self, world: World, line: SensorLine) -> None:
        self._world = world
        self._line = line
        self._kinematics = Kinematics()
        model = full_model()
        self._names = joint_names(model)
        self._position = home(model, world.start)
        self._effort = pin.computeGeneralizedGravity(model, model.createData(), self._position)
        self._driven = np.array([self._names.index(name) for name in CHAIN])
        self._head = [self._names.index(name) for name in HEAD]
        self._fingers = [self._names.index(name) for name in FINGERS]

    def measure(self) -> tuple[JointState, EndEffector]:
        """Joint states and the tool's pose and twist, as the encoders have them."""
        physics = self._world.arm.physics
        position, velocity, effort = self._line.stick(
            lambda: (physics.position, physics.velocity, physics.effort())
        )
        position = self._line.shift(position)
        all_positions, all_velocities = self._position.copy(), np.zeros(len(self._names))
        all_efforts = self._effort.copy()
        all_positions[self._driven] = position
        gripper = self._world.gripper
        all_positions[self._fingers] = gripper.left, gripper.right
        all_positions[self._head] = self._world.head.position
        all_velocities[self._driven] = velocity
        all_efforts[self._driven] = effort
        self._kinematics.update(position)
        tool, rotation = self._kinematics.tool()
        twist = self._kinematics.jacobian().dot(velocity)
        return (
            JointState(self._names, all_positions, all_velocities, all_efforts),
            EndEffector(tool, quaternion(rotation), twist[:3], twist[3:]),
        )
