"""Head and gripper of a bridge: commands that hold until the next one, on their way to trajectory controllers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from shared.messages import GripperCommand, GripperState, HeadCommand
from shared.robot.far_side import TrajectoryPoint
from shared.robot.profile import Profile
from shared.spatial import Array

SHORTEST = 0.2
"""[s] that a motion of head or fingers takes at least."""
_HALT = 0.1  # [s] for coming to rest where they are
_STUCK = 0.002  # [m/s] of the opening below which fingers stand
_CLOSING_ON = 0.05  # [s] of standing after which something is being closed on: joint states come more often
_STUCK_FOR = 0.3  # [s] after which fingers that are to close further stand because of what is between them
_SQUEEZE = 0.008  # [m] of the opening by which fingers are led further than they get, at full effort
Measured = Mapping[str, float]


class Head:
    """Pan and tilt.

    Args:
        profile: of the robot, which has a head.
        scale: share [1] of its speed to use.
    """

    def __init__(self, profile: Profile, scale: float) -> None:
        assert profile.head is not None
        self.controller = profile.head.controller
        self._pan, self._tilt = profile.head.joints
        self._order = profile.controllers[self.controller].joints
        joints = profile.description.joints
        self._speed = 0.5 * scale * min(joints[joint].velocity for joint in profile.head.joints)
        self._moving = 0.0

    def command(self, command: HeadCommand, measured: Measured) -> Sequence[TrajectoryPoint]:
        """The trajectory to what is wanted, from positions [rad] by names."""
        wanted = {self._pan: command.pan, self._tilt: command.tilt}
        way = max(abs(wanted[joint] - measured[joint]) for joint in wanted)
        self._moving = max(SHORTEST, way / self._speed)
        return [_rest([wanted[joint] for joint in self._order], self._moving)]

    def freeze(self, measured: Measured) -> Sequence[TrajectoryPoint]:
        """The trajectory that ends a motion where it is; none if there is no motion."""
        if self._moving <= 0.0:
            return []
        self._moving = 0.0
        return [_rest([measured[joint] for joint in self._order], _HALT)]

    def advance(self, dt: float) -> None:
        """Let ``dt`` [s] pass."""
        self._moving -= dt


class Fingers:
    """A gripper's fingers, each of which goes half the opening.

    No effort can be told to a position controller. So the fingers close at their speed until they stand, and are then
    led further than they get by so much as the effort says: what they hold is held by the controller's stiffness.

    Attributes:
        holding: whether something is between them that keeps them from closing.

    Args:
        profile: of the robot, which has a gripper.
        scale: share [1] of its speed to use.
    """

    def __init__(self, profile: Profile, scale: float) -> None:
        assert profile.gripper is not None
        self._gripper = gripper = profile.gripper
        self.controller = gripper.controller
        self._order = profile.controllers[self.controller].joints
        self._speed = scale * gripper.speed
        self.holding = False
        self._wanted: float | None = None
        self._squeeze = gripper.caught
        self._last = 0.0
        self._stuck = 0.0

    def command(self, command: GripperCommand, measured: Measured) -> Sequence[TrajectoryPoint]:
        """The trajectory to what is wanted, from positions [m] by names."""
        share = command.effort / (self._gripper.effort[1] or 1.0)
        self._squeeze = max(self._gripper.caught, share * _SQUEEZE)
        self.holding = self.holding and command.opening < self._opening(measured)
        self._stuck = 0.0
        return self._to(command.opening, measured)

    def freeze(self, measured: Measured) -> Sequence[TrajectoryPoint]:
        """The trajectory that ends a motion where it is; none where something is held, or being closed on."""
        if self._wanted is None or self.holding or self._stuck > _CLOSING_ON:
            return []
        return self._to(self._opening(measured), measured)

    def advance(self, measured: Measured, dt: float) -> Sequence[TrajectoryPoint]:
        """Watch the fingers for ``dt`` [s]; the trajectory to hold what they have just caught, if they have."""
        opening = self._opening(measured)
        speed, self._last = abs(opening - self._last) / dt if dt > 0.0 else 0.0, opening
        if self._wanted is None:
            return []
        ahead = opening - self._wanted
        if self.holding:
            self.holding = ahead > 0.5 * self._gripper.caught
            return []
        closing = ahead > self._gripper.caught
        self._stuck = self._stuck + dt if closing and speed < _STUCK else 0.0
        if self._stuck < _STUCK_FOR:
            return []
        self.holding = True
        return self._to(opening - self._squeeze, measured)

    def state(self, measured: Measured, effort: Measured) -> GripperState:
        """What is told of it, by the joints' positions [m] and efforts [N]."""
        pressed = max(abs(effort[joint]) for joint in self._gripper.joints)
        return GripperState(max(0.0, self._opening(measured)), min(pressed, self._gripper.effort[1]), self.holding)

    def _opening(self, measured: Measured) -> float:
        return sum(measured[joint] for joint in self._gripper.joints)

    def _to(self, opening: float, measured: Measured) -> Sequence[TrajectoryPoint]:
        self._wanted = max(opening, self._gripper.opening[0])
        way = abs(self._wanted - self._opening(measured))
        half = 0.5 * self._wanted
        return [_rest([half] * len(self._order), max(SHORTEST, way / self._speed))]


def _rest(position: Sequence[float], after: float) -> TrajectoryPoint:
    place: Array = np.array(position)
    return TrajectoryPoint(after, place, np.zeros(len(place)))
