"""The simulated robot's own control of its arm: an executed tool twist becomes motion of the motors' set-points."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from services.sim.robot.base import MobileBase
from services.sim.robot.kinematics import HOME, arm_kinematics
from services.sim.robot.physics import Physics
from shared.robot.ik import DifferentialIK
from shared.robot.kinematics import Kinematics
from shared.robot.posture import Lift, Posture
from shared.robot.tiago import CHAIN, TORSO
from shared.spatial import GRAVITY, Array

TORSO_WEIGHT = 10.0  # [1] cost of the torso's speed [m/s] relative to that of an arm joint [rad/s]
LOWEST_TOOL = 0.3  # [m] of the tool's height at which the torso is all the way down; above they share the way
TORSO_BOTTOM = 0.01  # [m] of the torso all the way down
TORSO_MARGIN, ARM_MARGIN = 0.003, 0.01  # [m, rad] from their position limits, where the joints stand still
SLACK = 0.02
"""[rad, m] Farthest that a set-point runs ahead of a joint that cannot follow because its effort is at the limit."""
GRIPPER_CENTRE = -0.0635
"""[m] Centre of mass of what is beyond the force-torque sensor, along the tool's x axis. What the arm feels of the
base's turning is worked out there, and taken for the same all along the arm: only its motors notice."""
DRIVE_LAG = 0.015  # [s] time constant of the drives: the tool follows its commanded twist as a first-order lag
AT_REST = 1e-5  # [m/s, rad/s] of a joint that count as none, so that the arm comes to rest in finite time
IK_PERIOD = 0.01  # [s] after which an unchanged twist is resolved into joint velocities anew: the arm has moved
_STANDING = [0.0] * len(CHAIN)


class JointSetPoint(NamedTuple):
    """What the motors are told of each joint of the chain, 8 each [m, rad, m/s, rad/s]."""

    position: list[float]
    velocity: list[float]


class Arm:
    """Torso and right arm: kinematics, inverse kinematics and physics together.

    The motors hold positions. What is commanded integrates into their set-points, so a zero twist keeps the joints
    exactly where they were told to be, whatever hangs on the tool.

    What happens in every step is written in plain floats, see ``Physics``, and poses are computed when asked for.

    Attributes:
        limited_by: why the last twist was not executed in full, or "".

    Args:
        step: duration [s] of one physics step.
        start: positions [m, rad] of the joints at the start, by name; the redundant ones are drawn back to them.
    """

    def __init__(self, step: float, start: Mapping[str, float] = HOME) -> None:
        model = self._kinematics = arm_kinematics(start)
        self.physics = Physics(model.home, model.effort, step)
        weight = np.array([TORSO_WEIGHT] + [1.0] * (len(CHAIN) - 1))
        margin = np.array([TORSO_MARGIN] + [ARM_MARGIN] * (len(CHAIN) - 1))
        self._ik = DifferentialIK(model.lower, model.upper, model.speed, margin, CHAIN, weight)
        self._response = 1.0 - math.exp(-step / DRIVE_LAG)
        self._ik_steps = max(1, round(IK_PERIOD / step))
        lift = Lift(CHAIN.index(TORSO), TORSO_BOTTOM, LOWEST_TOOL, model.tool()[0][2])
        self._posture = Posture(model.home, lift)
        self.reset()

    def reset(self) -> None:
        """Back to the start, at rest."""
        self.physics.reset()
        self._stale = True
        self._set_point: list[float] = self._kinematics.home.tolist()
        self._was_moving = False
        self._wanted = _STANDING
        self._velocity = _STANDING
        self._solved_for = [0.0] * 6
        self._steps_to_ik = 0
        self.limited_by = ""

    @property
    def kinematics(self) -> Kinematics:
        """Of the joints' present positions."""
        if self._stale:
            self._kinematics.update(self.physics.position)
            self._stale = False
        return self._kinematics

    @property
    def tool_position(self) -> Array:
        """Position (3,) [m] of the tool in base."""
        return self.kinematics.tool_position()

    @property
    def tool_twist(self) -> Array:
        """Twist (6,) [m/s, rad/s] of the tool, base axes."""
        return self.kinematics.jacobian().dot(self.physics.velocity)

    def feel(self, base: MobileBase) -> None:
        """Let the arm feel its weight and the motion of the base that carries it."""
        if base.at_rest:
            x, y, z = base.down
            self.physics.feel((GRAVITY * x, GRAVITY * y, GRAVITY * z))
            return
        position, rotation = self.kinematics.tool()
        x, y, z = (position + GRIPPER_CENTRE * rotation[:, 0]).tolist()
        vx, vy, vz, *_ = self.tool_twist.tolist()
        self.physics.feel(base.gravity((x, y, z), (vx, vy, vz)))

    def advance(self, wanted: Array | JointSetPoint, force: list[float], torque: list[float] | None) -> None:
        """One physics step.

        Args:
            wanted: the gate's twist (6,), or where whoever commands the joints themselves has them.
            force: the environment's [N] at the tool.
            torque: the environment's [Nm] there; None for none.
        """
        if isinstance(wanted, JointSetPoint):
            moving = self._go(wanted)
        else:
            moving = self._follow(wanted.tolist())
            if moving:
                step = self.physics.step_time
                self._set_point = [
                    place + velocity * step for place, velocity in zip(self._set_point, self._velocity, strict=True)
                ]
        if self._bound() or moving or self._was_moving:
            self.physics.drive(self._set_point, self._velocity)
        self._was_moving = moving
        if torque is not None or any(force):
            self.physics.push(force, torque, self.tool_position.tolist())
        self.physics.step()
        self._stale = True

    def _go(self, wanted: JointSetPoint) -> bool:
        """Take over set-points; false once they are at rest."""
        moving = wanted.position != self._set_point or any(wanted.velocity)
        self._set_point, self._velocity = wanted
        return moving

    def _follow(self, twist: list[float]) -> bool:
        """Let the drives follow a twist; false once they are at rest."""
        if any(twist):
            self._steps_to_ik -= 1
            if self._steps_to_ik <= 0 or twist != self._solved_for:
                self._wanted = self._solve(twist)
                self._solved_for = twist
                self._steps_to_ik = self._ik_steps
        elif self._was_moving:
            self._wanted = _STANDING
            self._steps_to_ik = 0
            if max(map(abs, self._velocity)) < AT_REST:
                self._velocity = _STANDING
                return False
        else:
            return False
        response = self._response
        self._velocity = [
            velocity + response * (wanted - velocity)
            for velocity, wanted in zip(self._velocity, self._wanted, strict=True)
        ]
        return True

    def _solve(self, twist: list[float]) -> list[float]:
        kinematics = self.kinematics
        reference, lead = self._posture.at(kinematics.tool_position()[2], twist[2])
        solution = self._ik.solve(np.array(self._set_point), kinematics.jacobian(), np.array(twist), reference, lead)
        self.limited_by = solution.limited_by
        velocities: list[float] = solution.velocity.tolist()
        return velocities

    def _bound(self) -> bool:
        """Keep the set-points within reach of the joints; true if one had to be moved."""
        positions = self.physics.positions
        lead = [place - position for place, position in zip(self._set_point, positions, strict=True)]
        if max(lead) <= SLACK and min(lead) >= -SLACK:
            return False
        self._set_point = [
            position + min(max(ahead, -SLACK), SLACK) for position, ahead in zip(positions, lead, strict=True)
        ]
        return True
