"""The arm of a bridge: the gate's twist becomes set-points of the joints, and these the trajectories of controllers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from shared.robot.bridge.motion import APPROACH_RATE, REST_WITHIN, JointMotion
from shared.robot.far_side import TrajectoryPoint
from shared.robot.ik import DifferentialIK
from shared.robot.kinematics import Kinematics, full_model, locked_except
from shared.robot.posture import Lift, Posture
from shared.robot.profile import Profile
from shared.spatial import Array

ADRIFT_AFTER = 0.5  # [s] at rest after which joints that are elsewhere are where somebody else has led them
_INSTANT = 1e-6  # [s] that are none
_MARGIN = 0.01  # [rad, m] from their limits where joints stand still, if the profile says nothing


def kinematics_of(profile: Profile) -> Kinematics:
    """Kinematics of the arm that a profile names."""
    model = locked_except(full_model(profile.urdf), profile.arm.joints, {})
    middle = 0.5 * (model.lowerPositionLimit + model.upperPositionLimit)
    home = np.array(profile.arm.home) if profile.arm.home else middle
    return Kinematics(model, profile.frames.tool, profile.frames.sensor, home)


class Arm:
    """Set-points of the arm.

    Attributes:
        limited_by: why the last twist was not executed in full, or "".

    Args:
        profile: of the robot.
        scale: share [1] of its limits to use.
        period: between two trajectories [s].
    """

    def __init__(self, profile: Profile, scale: float, period: float) -> None:
        arm = profile.arm
        model = self._kinematics = kinematics_of(profile)
        speed = np.array(arm.speed) if arm.speed else model.speed
        n = len(arm.joints)
        margin = np.array(arm.margin) if arm.margin else np.full(n, _MARGIN)
        weight = np.array(arm.weight) if arm.weight else np.ones(n)
        self._motion = JointMotion(model.lower, model.upper, scale * speed, scale * np.array(arm.acceleration))
        limits = model.lower, model.upper, self._motion.speed
        self._ik = DifferentialIK(*limits, margin, arm.joints, weight, APPROACH_RATE)
        self._posture = _posture(profile, model) if arm.home else None
        self._controllers = profile.arm_controllers()
        self._period = period
        self._standing = np.zeros(n)
        self._age = np.inf
        self._rested = 0.0
        self.limited_by = ""

    @property
    def moving(self) -> bool:
        """Whether the arm is to move."""
        return self._motion.moving(self._age)

    def start(self, measured: Array) -> None:
        """Take over from where the joints are (n,) [rad, m], at rest."""
        self._motion.start(measured)
        self._posture = self._posture or Posture(measured)
        self._rested = 0.0
        self.limited_by = ""

    def advance(self, twist: Array, measured: Array, passed: float) -> Iterator[tuple[str, Sequence[TrajectoryPoint]]]:
        """What is to be told now to which of the profile's controllers: nothing while the arm is to rest.

        Args:
            twist: that the gate lets through (6,) [m/s, rad/s].
            measured: positions (n,) [rad, m] of the joints.
            passed: since the last call [s], however long that is.
        """
        motion = self._motion
        self._age += passed
        position, velocity = motion.at(self._age)
        if not twist.any():
            self.limited_by = ""
            # What was told last has come to rest by itself, however long nothing ran here: what is known of the joints
            # may be older than that, and no reason to move them.
            if motion.ends or self._age > REST_WITHIN:
                self._rest(position, measured, passed)
                return
        elif self._age < self._period - _INSTANT and not motion.ends:
            return
        self._rested = 0.0
        position = motion.near(position, velocity, measured)
        wanted = self._solve(position, twist) if twist.any() else self._standing
        points = motion.tell(position, velocity, wanted)
        self._age = 0.0
        for name, places in self._controllers.items():
            yield name, [_of(point, list(places)) for point in points]

    def _rest(self, position: Array, measured: Array, passed: float) -> None:
        """Notice when somebody else leads the arm elsewhere meanwhile."""
        self._rested += passed
        if self._rested > ADRIFT_AFTER and (self._motion.near(position, self._standing, measured) != position).any():
            self._motion.start(measured)

    def _solve(self, position: Array, twist: Array) -> Array:
        assert self._posture is not None
        kinematics = self._kinematics
        kinematics.update(position)
        posture = self._posture.at(kinematics.tool_position()[2], twist[2])
        solution = self._ik.solve(position, kinematics.jacobian(), twist, *posture)
        self.limited_by = solution.limited_by
        return solution.velocity


def _posture(profile: Profile, model: Kinematics) -> Posture:
    lift = profile.arm.lift
    if lift is None:
        return Posture(model.home)
    height = model.tool_position()[2]
    return Posture(model.home, Lift(profile.arm.joints.index(lift.joint), lift.bottom, lift.lowest_tool, height))


def _of(point: TrajectoryPoint, places: list[int]) -> TrajectoryPoint:
    return TrajectoryPoint(point.after, point.position[places], point.velocity[places])
