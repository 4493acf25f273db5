"""Kinematics and statics of a robot's arm, from the robot's description."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pinocchio as pin

from shared.spatial import Array


def full_model(urdf: Path) -> pin.Model:
    """The whole robot on its fixed root link."""
    return pin.buildModelFromUrdf(str(urdf))


def joint_names(model: pin.Model) -> tuple[str, ...]:
    """Names of the movable joints in the order of the model's configuration."""
    return tuple(model.names[1:])


def configuration(model: pin.Model, positions: Mapping[str, float]) -> Array:
    """Positions [m, rad] in the order of ``joint_names(model)``; joints not named stand at zero."""
    return np.array([positions.get(name, 0.0) for name in joint_names(model)])


def locked_except(model: pin.Model, free: tuple[str, ...], positions: Mapping[str, float]) -> pin.Model:
    """The model with all joints but the ``free`` ones fixed at their positions."""
    locked = [model.getJointId(name) for name in joint_names(model) if name not in free]
    return pin.buildReducedModel(model, locked, configuration(model, positions))


class Kinematics:
    """Forward kinematics of the chain from the root to the tool; results refer to the last ``update``.

    ``base`` is the root's frame. The chain has n joints.

    Attributes:
        lower, upper, speed, effort: limits of the joints (n,) each [m, rad, m/s, rad/s, N, Nm].
        home: positions (n,) [m, rad] at the start.
        tool_in_sensor: tool's origin (3,) [m] from the sensor's, in its axes.

    Args:
        model: of the chain's joints only.
        tool, sensor: frames that its last joint carries.
        home: as above.
    """

    def __init__(self, model: pin.Model, tool: str, sensor: str, home: Array) -> None:
        self._model = model
        self._data = model.createData()
        self._tool = model.getFrameId(tool)
        self._sensor = model.getFrameId(sensor)
        self.lower: Array = model.lowerPositionLimit.copy()
        self.upper: Array = model.upperPositionLimit.copy()
        self.speed: Array = model.velocityLimit.copy()
        self.effort: Array = model.effortLimit.copy()
        self.home = home
        self.update(self.home)
        pin.updateFramePlacement(self._model, self._data, self._sensor)
        tool_in_sensor = self._data.oMf[self._sensor].actInv(self._tool_pose)
        self.tool_in_sensor: Array = tool_in_sensor.translation.copy()

    def update(self, position: Array) -> None:
        """Compute poses and Jacobians for the chain's joint positions (n,) [m, rad]."""
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
        """Jacobian (6, n): joint velocities to the tool's twist in base axes."""
        return pin.getFrameJacobian(self._model, self._data, self._tool, pin.LOCAL_WORLD_ALIGNED)

    def holding_effort(self, position: Array, force: Array) -> Array:
        """Efforts (n,) [N, Nm] that hold the chain still while ``force`` (3,) [N, base axes] acts on the tool."""
        gravity = pin.computeGeneralizedGravity(self._model, self._data, position)
        self.update(position)
        return gravity - self.jacobian()[:3].T @ force


class FramePose:
    """Pose of one frame in base, such as a camera's, by the positions of the joints that carry it.

    Args:
        urdf: the description.
        joints: that carry the frame.
        frame: its name.
    """

    def __init__(self, urdf: Path, joints: tuple[str, ...], frame: str) -> None:
        self._model = locked_except(full_model(urdf), joints, {})
        self._data = self._model.createData()
        self._frame = self._model.getFrameId(frame)

    def at(self, positions: Mapping[str, float]) -> tuple[Array, Array]:
        """Position (3,) [m] and rotation (3, 3) at positions [m, rad] of joints by their names."""
        pin.framesForwardKinematics(self._model, self._data, configuration(self._model, positions))
        pose = self._data.oMf[self._frame]
        return pose.translation.copy(), pose.rotation.copy()
