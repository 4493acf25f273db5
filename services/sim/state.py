"""What the robot tells about itself: messages made of the arm's state."""

from __future__ import annotations

import pinocchio as pin

from services.sim.arm import Arm
from services.sim.kinematics import CHAIN, Kinematics, full_model, home, joint_names
from services.sim.sensor_faults import SensorLine
from shared.messages import EndEffector, JointState
from shared.spatial import Array, quaternion


class JointSensors:
    """The joints' encoders, and what the robot computes from them.

    Joints that this simulation does not drive (left arm, head, grippers) are reported where they are held, with the
    effort that their weight takes.
    """

    def __init__(self, arm: Arm, line: SensorLine) -> None:
        self._arm = arm
        self._line = line
        self._kinematics = Kinematics()
        model = full_model()
        self._names = joint_names(model)
        held = home(model)
        self._position: list[float] = held.tolist()
        self._effort: list[float] = pin.computeGeneralizedGravity(model, model.createData(), held).tolist()
        self._driven = [self._names.index(name) for name in CHAIN]

    def measure(self) -> tuple[JointState, EndEffector]:
        """Joint states and the tool's pose and twist, as the encoders have them."""
        physics = self._arm.physics
        position, velocity, effort = self._line.stick(
            lambda: (physics.position, physics.velocity, physics.effort())
        )
        position = self._line.shift(position)
        self._kinematics.update(position)
        tool, rotation = self._kinematics.tool()
        twist = self._kinematics.jacobian().dot(velocity)
        return (
            JointState(
                self._names,
                self._with_driven(self._position, position),
                self._with_driven([0.0] * len(self._names), velocity),
                self._with_driven(self._effort, effort),
            ),
            EndEffector(tool, quaternion(rotation), twist[:3], twist[3:]),
        )

    def _with_driven(self, held: list[float], driven: Array) -> list[float]:
        """Values of all joints: as they are held, but for the driven ones (8,)."""
        values = held.copy()
        for joint, value in zip(self._driven, driven.tolist(), strict=True):
            values[joint] = value
        return values
