"""The robot's controllers and who of them runs, as ``controller_manager`` lists and switches them.

Of two controllers that move the same joint one runs at most. Besides the trajectory controllers that its profile names
the robot has a group velocity controller for the same joints of the arm, which is loaded and does not run.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from services.ros_robot.messages import ControllerState, Middleware, Trajectory, Velocities
from services.ros_robot.trajectory_controller import JointTrajectoryController
from services.ros_robot.velocity_controller import GroupVelocityController
from shared.robot.profile import Profile
from shared.robot.tiago import JOINTS
from shared.spatial import Array

STRICT = 2
"""``strictness`` of a switch that is done as a whole or not at all; 1 does what can be done."""
_STATES: Mapping[Middleware, tuple[str, str]] = {"ros1": ("stopped", "running"), "ros2": ("inactive", "active")}
_TRAJECTORY: Mapping[Middleware, str] = {
    "ros1": "position_controllers/JointTrajectoryController",
    "ros2": "joint_trajectory_controller/JointTrajectoryController",
}
_VELOCITY = "velocity_controllers/JointGroupVelocityController"


class ControllerManager:
    """All controllers, and the set-points that come out of them.

    Attributes:
        trajectory, velocity: the controllers of each kind by the topics of their commands.
        position, velocities: set-points of every joint [rad, m], [rad/s, m/s] by its name.

    Args:
        profile: names the trajectory controllers.
        start: positions [rad, m] of the joints at the start by name; those not named are at zero.
        switchable: whether the arm's controller runs, and switching works at all.
    """

    def __init__(self, profile: Profile, start: Mapping[str, float], switchable: bool = True) -> None:
        self._middleware = profile.middleware
        self._switchable = switchable
        self._emergency = False
        self.position = {joint: start.get(joint, 0.0) for joint in JOINTS}
        self.velocities = dict.fromkeys(JOINTS, 0.0)
        self.trajectory: dict[str, JointTrajectoryController] = {}
        self.velocity: dict[str, GroupVelocityController] = {}
        for name, row in profile.controllers.items():
            controller = JointTrajectoryController(
                profile.middleware, row.controller, row.joints, self._positions(row.joints)
            )
            controller.running = switchable or name != "arm"
            self.trajectory[row.topic] = controller
            if name == "arm":
                limits = np.array([JOINTS[joint][:3] for joint in row.joints]).T
                other = row.controller.removesuffix("_controller") + "_forward_velocity_controller"
                topic = f"/{other}/{'command' if profile.middleware == 'ros1' else 'commands'}"
                self.velocity[topic] = GroupVelocityController(other, row.joints, *limits)

    def command(self, topic: str, message: Trajectory | Velocities, now: float, start: float) -> str:
        """Hand a command to the controller of a topic; why it is refused, or "". Times as for the controllers."""
        if self._emergency:
            return "the emergency stop is pressed"
        if topic in self.trajectory and isinstance(message, Trajectory):
            return self.trajectory[topic].command(message, now, start)
        if topic in self.velocity and isinstance(message, Velocities):
            return self.velocity[topic].command(message)
        return f"{topic} takes no {type(message).__name__}"

    def listed(self) -> tuple[ControllerState, ...]:
        """What ``list_controllers`` replies."""
        states = _STATES[self._middleware]
        return tuple(
            ControllerState(one.name, states[one.running and not self._emergency], self._kind(one), one.joints)
            for one in self._all()
        )

    def switch(self, start: Sequence[str], stop: Sequence[str], strictness: int = STRICT) -> bool:
        """What ``switch_controller`` does: whether it is done."""
        known = {controller.name: controller for controller in self._all()}
        wanted = set(start) & set(known), set(stop) & set(known)
        running = {name for name, controller in known.items() if controller.running}
        if not self._switchable or self._emergency:
            return False
        if strictness == STRICT and (
            {*start, *stop} - set(known) or wanted[0] & running - wanted[1] or wanted[1] - running
        ):
            return False
        after = (running - wanted[1]) | wanted[0]
        claimed = [joint for name in after for joint in known[name].joints]
        if len(set(claimed)) != len(claimed):
            return False
        for name, controller in known.items():
            if name in after and not controller.running:
                controller.hold(self._positions(controller.joints))
            controller.running = name in after
        return True

    def advance(self, now: float, dt: float) -> None:
        """Let the controllers that run set their joints' set-points for a time [s], ``dt`` [s] after the last call.

        Where none runs the drives hold their position.
        """
        self.velocities = dict.fromkeys(self.velocities, 0.0)
        if self._emergency:
            return
        for controller in self.trajectory.values():
            if controller.running:
                self._set(controller.joints, *controller.sample(now))
        for group in self.velocity.values():
            if group.running:
                self._set(group.joints, *group.advance(dt))

    def press(self, pressed: bool, position: Mapping[str, float]) -> None:
        """Press the emergency stop, or release it: in both cases joints stay at their positions [rad, m] by name."""
        self._emergency = pressed
        self.set_back(position)

    def set_back(self, position: Mapping[str, float]) -> None:
        """Hold joints at positions [rad, m] by name, whatever was commanded before."""
        self.position.update(position)
        for controller in self._all():
            controller.hold(self._positions(controller.joints))

    def _all(self) -> list[JointTrajectoryController | GroupVelocityController]:
        return [*self.trajectory.values(), *self.velocity.values()]

    def _kind(self, controller: JointTrajectoryController | GroupVelocityController) -> str:
        return _VELOCITY if isinstance(controller, GroupVelocityController) else _TRAJECTORY[self._middleware]

    def _positions(self, joints: Sequence[str]) -> Array:
        return np.array([self.position[joint] for joint in joints])

    def _set(self, joints: Sequence[str], position: Array, velocity: Array) -> None:
        self.position.update(zip(joints, position.tolist(), strict=True))
        self.velocities.update(zip(joints, velocity.tolist(), strict=True))
