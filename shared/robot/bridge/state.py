"""What the robot says, taken together: positions by names, which of them count, and the messages of the contract."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping

import numpy as np

from shared.clock import seconds
from shared.messages import EndEffector, FtSample, JointState
from shared.robot.bridge.arm import kinematics_of
from shared.robot.far_side import Heard, Joints, Wrench
from shared.robot.kinematics import FramePose
from shared.robot.profile import Profile
from shared.spatial import Array, quaternion

SILENT_AFTER = 0.25
"""[s] without joint states after which the robot is not to be moved."""
_REMEMBERED = 10**9  # [ns] of joint states that images may be older than
_LEAP = 0.1  # [rad, m] that a joint may be elsewhere than its speed allows: rates are not exact


class RobotState:
    """The newest of joints and wrist.

    Attributes:
        position, velocity: of the arm's joints (n,) [rad, m, rad/s, m/s], as they were told last.
        positions, efforts: of all joints by name [rad, m, Nm, N].
        absent: joints that the profile names and the robot does not tell.
        leapt: joint that was told where it cannot have got so soon; empty if none was.

    Args:
        profile: of the robot.
    """

    def __init__(self, profile: Profile) -> None:
        self.profile = profile
        self._arm = profile.arm.joints
        self._kinematics = kinematics_of(profile)
        self._speed = self._kinematics.speed
        self.position: Array = self._kinematics.home.copy()
        self.velocity: Array = np.zeros(len(self._arm))
        self.positions: Mapping[str, float] = {}
        self.efforts: Mapping[str, float] = {}
        self.absent: tuple[str, ...] = ()
        self.leapt = ""
        self._known = tuple(dict.fromkeys((*self._arm, *(j for c in profile.controllers.values() for j in c.joints))))
        self._arrival: int | None = None
        self._stamped: deque[tuple[int, Mapping[str, float]]] = deque()
        self._axes = profile.wrench.axes
        self._saturation = np.array(profile.wrench.saturation)
        self._camera: FramePose | None = None
        if profile.frames.camera:
            carrying = profile.description.chain(profile.frames.camera)
            self._camera = FramePose(profile.urdf, carrying, profile.frames.camera)

    @property
    def down(self) -> Array:
        """Direction of gravity (3,) in sensor axes, with the joints where they were told last."""
        self._kinematics.update(self.position)
        _, rotation = self._kinematics.sensor()
        return -rotation[2]

    def age(self, now: int) -> float:
        """Age [s] of the joint states that count; infinite without any."""
        return np.inf if self._arrival is None else seconds(now - self._arrival)

    def take(self, heard: Heard[Joints], now: int) -> bool:
        """Take over joint states; false if they cannot be those of this arm, and do not count."""
        joints = heard.message
        positions = dict(zip(joints.names, joints.position.tolist(), strict=True))
        self.absent = tuple(joint for joint in self._known if joint not in positions)
        if self.absent:
            return False
        position = np.array([positions[joint] for joint in self._arm])
        if (age := self.age(now)) < SILENT_AFTER:
            far = np.abs(position - self.position) - self._speed * (age + seconds(now - heard.arrival)) - _LEAP
            if (far > 0.0).any():
                self.leapt = self._arm[int(far.argmax())]
                return False
        velocities = dict(zip(joints.names, joints.velocity.tolist(), strict=True))
        self.position = position
        self.velocity = np.array([velocities[joint] for joint in self._arm])
        self.positions = positions
        self.efforts = dict(zip(joints.names, joints.effort.tolist(), strict=True))
        self._arrival = heard.arrival
        if heard.stamp is not None:
            self._stamped.append((heard.stamp, positions))
            while abs(heard.stamp - self._stamped[0][0]) > _REMEMBERED:
                self._stamped.popleft()
        return True

    def extrapolated(self, at: int) -> Array:
        """Positions (n,) [rad, m] of the arm's joints at a moment [ns] after they were told, at the speed told then."""
        ahead = min(max(self.age(at), 0.0), SILENT_AFTER)
        return self.position + ahead * self.velocity

    def joint_state(self, heard: Heard[Joints]) -> JointState:
        """The message of joint states."""
        joints = heard.message
        return JointState(joints.names, joints.position, joints.velocity, joints.effort)

    def tool(self) -> EndEffector:
        """The message of the tool's pose and twist."""
        self._kinematics.update(self.position)
        place, rotation = self._kinematics.tool()
        twist = self._kinematics.jacobian() @ self.velocity
        return EndEffector(place, quaternion(rotation), twist[:3], twist[3:])

    def sample(self, heard: Heard[Wrench]) -> FtSample:
        """The message of a reading of the wrist's sensor."""
        wrench = heard.message
        told = np.concatenate((wrench.force, wrench.torque))
        self._kinematics.update(self.extrapolated(heard.arrival))
        _, rotation = self._kinematics.sensor()
        return FtSample(
            self._axes @ wrench.force,
            self._axes @ wrench.torque,
            quaternion(rotation),
            self._kinematics.tool_in_sensor,
            bool((np.abs(told) >= self._saturation).any()),
        )

    def camera(self, stamp: int | None) -> tuple[Array, Array, float] | None:
        """Pose of the camera in base when an image was taken; None if there is no camera, or no joint states yet.

        Images come later than joint states: a head that turns is elsewhere by then. Both have stamps of one clock.

        Args:
            stamp: of the image [ns].

        Returns:
            Position (3,) [m], rotation (3, 3), and how much older [s] the image is than the newest joint states; 0 if
            their stamps do not tell.
        """
        if self._camera is None or not self.positions:
            return None
        if stamp is None or not self._stamped or abs(stamp - self._stamped[-1][0]) > _REMEMBERED:
            return *self._camera.at(self.positions), 0.0
        _, positions = min(self._stamped, key=lambda told: abs(told[0] - stamp))
        return *self._camera.at(positions), max(0.0, seconds(self._stamped[-1][0] - stamp))
