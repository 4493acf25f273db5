"""Kinematics and statics of the simulated TIAGo's torso and right arm, from the robot's description."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pinocchio as pin

from shared.robot.tiago import CHAIN, SENSOR_FRAME, TOOL_FRAME, URDF
from shared.spatial import Array

HOME = {
    "torso_lift_joint": 0.345,
    "arm_right_1_joint": 0.66393062,
    "arm_right_2_joint": 1.07003071,
    "arm_right_3_joint": 1.02240766,
    "arm_right_4_joint": 2.3362,
    "arm_right_5_joint": 1.51284625,
    "arm_right_6_joint": 1.06685273,
    "arm_right_7_joint": 0.45070951,
    "arm_left_1_joint": 0.25,
    "arm_left_2_joint": 1.4,
    "arm_left_3_joint": 1.57,
    "arm_left_4_joint": 0.7,
    "arm_left_5_joint": 0.0,
    "arm_left_6_joint": 0.0,
    "arm_left_7_joint": 0.0,
    "head_1_joint": -0.45,
    "head_2_joint": -0.35,
}
"""Positions [m, rad] at the start; joints not named stand at zero.

The tool is at (0.5, -0.3, 1.0) m with the axes of the base. There the forearm's roll joint, which yields above 3 Nm,
decides what the arm can carry: with the elbow out to the side, where most solutions have it, a weight of 15 N at the
tool is too much. Here the elbow is low, the torso high and the elbow joint nearly closed, and 28 N at the tool take 2.5
of its 3 Nm. Going down only makes that easier.
"""

FULL_HOME = HOME | {"head_2_joint": -0.5}
"""The same with the head lowered a little, so that the whole marker on the panel is in the picture."""

CARRY_HOME = HOME | {
    "torso_lift_joint": 0.22344,
    "arm_right_1_joint": 0.09663,
    "arm_right_2_joint": 0.66368,
    "arm_right_3_joint": 1.70416,
    "arm_right_4_joint": 2.13967,
    "arm_right_5_joint": 1.25789,
    "arm_right_6_joint": 0.67047,
    "arm_right_7_joint": -0.40282,
}
"""The start in the carrying scenario: the tool at (0.45, -0.39, 0.78) m in front of the panel's edge, rolled by -90
degrees, so that the fingers are above and below the panel. From here the onboard inverse kinematics reaches x 0.45 to
0.6 m and z 0.3 to 1.05 m over the whole turn of the panel to roll 0, with yaw and pitch of 15 degrees.
"""


def full_model() -> pin.Model:
    """The whole robot on its fixed ``base_footprint``."""
    return pin.buildModelFromUrdf(str(URDF))


def joint_names(model: pin.Model) -> tuple[str, ...]:
    """Names of the movable joints in the order of the model's configuration."""
    return tuple(model.names[1:])


def home(model: pin.Model, start: Mapping[str, float] = HOME) -> Array:
    """A start configuration [m, rad] in the order of ``joint_names(model)``."""
    return np.array([start.get(name, 0.0) for name in joint_names(model)])


def locked_except(model: pin.Model, free: tuple[str, ...]) -> pin.Model:
    """The model with all joints but the ``free`` ones fixed at their start positions."""
    locked = [model.getJointId(name) for name in joint_names(model) if name not in free]
    return pin.buildReducedModel(model, locked, home(model))


class Kinematics:
    """Forward kinematics of the chain from ``base_footprint`` to the tool; results refer to the last ``update``.

    Args:
        start: positions [m, rad] of the joints at the start, by name.
    """

    def __init__(self, start: Mapping[str, float] = HOME) -> None:
        self._model = locked_except(full_model(), CHAIN)
        self._data = self._model.createData()
        self._tool = self._model.getFrameId(TOOL_FRAME)
        self._sensor = self._model.getFrameId(SENSOR_FRAME)
        self.lower: Array = self._model.lowerPositionLimit.copy()
        self.upper: Array = self._model.upperPositionLimit.copy()
        self.speed: Array = self._model.velocityLimit.copy()
        self.effort: Array = self._model.effortLimit.copy()
        self.home: Array = home(self._model, start)
        self.update(self.home)
        pin.updateFramePlacement(self._model, self._data, self._sensor)
        tool_in_sensor = self._data.oMf[self._sensor].actInv(self._tool_pose)
        self.tool_in_sensor: Array = tool_in_sensor.translation.copy()

    def update(self, position: Array) -> None:
        """Compute poses and Jacobians for the chain's joint positions (8,) [m, rad]."""
        pin.computeJointJacobians(self._model, self._data, position)
        self._tool_pose = pin.updateFramePlacement(self._model, self._data, self._tool)

    def tool(self) -> tuple[Array, Array]:
        """Position (3,) [m] and rotation (3, 3) of the tool in base."""
        pose = self._tool_pose
        return pose.translation.copy(), pose.rotation.copy()

    def tool_position(self) -> Array:
        """Position (3,) [m] of the tool in base."""
        return self._tool_pose.translation.copy()

    def sensor(self) -> tuple[Array, Array]:
        """Position (3,) [m] and rotation (3, 3) of the force-torque sensor in base."""
        pose = pin.updateFramePlacement(self._model, self._data, self._sensor)
        return pose.translation.copy(), pose.rotation.copy()

    def jacobian(self) -> Array:
        """Jacobian (6, 8): joint velocities to the tool's twist in base axes."""
        return pin.getFrameJacobian(self._model, self._data, self._tool, pin.LOCAL_WORLD_ALIGNED)

    def holding_effort(self, position: Array, force: Array) -> Array:
        """Efforts (8,) [N, Nm] that hold the chain still while ``force`` (3,) [N, base axes] acts on the tool."""
        gravity = pin.computeGeneralizedGravity(self._model, self._data, position)
        self.update(position)
        return gravity - self.jacobian()[:3].T @ force
