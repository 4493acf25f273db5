"""Whether the robot is what its profile says: everything that differs, one line each, at the start and ever after."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from shared.clock import seconds
from shared.robot.bridge.gravity import GravityWatch
from shared.robot.bridge.state import SILENT_AFTER, RobotState
from shared.robot.bridge.stream import REMEMBERED, StreamWatch
from shared.robot.far_side import FarSide, Heard, Joints, Odometry, Wrench
from shared.robot.profile import Profile

ASK_EVERY = 1.0
"""[s] between two questions for the robot's topics and types."""
_AT_REST = 0.01  # [rad/s, m/s] of every joint
_BASE_AT_REST = 0.005  # [m/s, rad/s]
_BEYOND = 0.05  # [rad, m] beyond a limit of the description that is no rounding


class Watch:
    """Reads the far side, and compares it with the profile.

    Attributes:
        state: what the robot says, as far as it counts.
        joints, wrench, odometry: what is new with the last ``look``; None if nothing is.
        base_velocity: by odometry (3,) vx, vy [m/s], wz [rad/s].

    Args:
        profile: of the robot.
        wall: this machine's wall clock [ns]: stamps are compared with it, and nothing else is.
    """

    def __init__(self, profile: Profile, wall: Callable[[], int]) -> None:
        self._profile = profile
        self._wall = wall
        self.state = RobotState(profile)
        self._joints_watch = StreamWatch(profile.joints.topic, profile.joints.rate)
        self._wrench_watch = StreamWatch(profile.wrench.topic, profile.wrench.rate)
        self._streams = [self._joints_watch, self._wrench_watch]
        if profile.base:
            self._odometry_watch = StreamWatch(profile.base.odometry, profile.base.rate)
            self._streams.append(self._odometry_watch)
        self._gravity = GravityWatch(profile.wrench.topic, profile.description.mass_beyond(profile.frames.sensor))
        self.joints: Heard[Joints] | None = None
        self.wrench: Heard[Wrench] | None = None
        self.odometry: Heard[Odometry] | None = None
        self.base_velocity = np.zeros(3)
        self._names: tuple[str, ...] = ()
        self._frame = ""
        self._reordered = self._leapt = -REMEMBERED
        self._now = 0.0
        self._asked = -ASK_EVERY
        self._mismatches: tuple[str, ...] = ()

    def look(self, far: FarSide, now: int) -> None:
        """Read what is new, at a moment [ns] of the steady clock."""
        self._now, wall = seconds(now), self._wall()
        joints, wrench = far.joints(), far.wrench()
        self.joints = joints if self._joints_watch.hear(joints, now, wall) else None
        self.wrench = wrench if self._wrench_watch.hear(wrench, now, wall) else None
        if self.wrench is not None:
            self._frame = self.wrench.message.frame
        if self.joints is not None and not self._take(self.joints, now):
            self.joints = None
        if self._profile.base:
            odometry = far.odometry()
            self.odometry = odometry if self._odometry_watch.hear(odometry, now, wall) else None
            if self.odometry is not None:
                self.base_velocity = self.odometry.message.velocity
        if self._now - self._asked >= ASK_EVERY:
            self._asked = self._now
            self._mismatches = tuple(far.mismatches())

    def weigh(self) -> None:
        """Compare the wrist's reading with gravity, if arm and base are at rest."""
        if self.wrench is not None and self.wrench_in_frame and self.state.positions:
            still = bool((np.abs(self.state.velocity) < _AT_REST).all())
            still &= bool((np.abs(self.base_velocity) < _BASE_AT_REST).all())
            force = self._profile.wrench.axes @ self.wrench.message.force
            self._gravity.hear(force, self.state.down, still, self._now)

    def forget_weights(self) -> None:
        """From now on something else may hang on the tool."""
        self._gravity.forget()

    @property
    def wrench_in_frame(self) -> bool:
        """Whether the wrist's readings are told in the frame that the profile says; true if they do not say."""
        return self._frame in ("", self._profile.frames.sensor)

    def silence(self, now: int) -> str:
        """Why it is not known where the arm is; empty if it is."""
        age = self.state.age(now)
        if age <= SILENT_AFTER:
            return ""
        topic = self._profile.joints.topic
        if self.state.absent:
            return f"{topic} does not tell {', '.join(self.state.absent)}"
        return f"no joint states on {topic}" + (f" for {age:.1f} s" if np.isfinite(age) else "")

    def lines(self) -> Iterator[str]:
        """What differs from the profile, one line each."""
        yield from self._mismatches
        for stream in self._streams:
            yield from stream.lines()
        profile, topic = self._profile, self._profile.joints.topic
        for joint in self.state.absent:
            yield f"{topic} does not tell {joint}, which the profile names"
        if self._now - self._reordered < REMEMBERED:
            yield f"{topic}: the order of joints changes from message to message; they are taken by their names"
        if self._now - self._leapt < REMEMBERED:
            yield (
                f"{topic}: {self.state.leapt} is told where it cannot have got so soon: such messages are not used. Do "
                "two programs publish there?"
            )
        for joint, place in zip(profile.arm.joints, self.state.position.tolist(), strict=True):
            limit = profile.description.joints[joint]
            if not limit.lower - _BEYOND <= place <= limit.upper + _BEYOND:
                yield (
                    f"{topic}: {joint} is at {place:.3g}, {profile.urdf.name} lets it go from {limit.lower:g} to "
                    f"{limit.upper:g}: is it another robot's description?"
                )
        if not self.wrench_in_frame:
            yield (
                f"{profile.wrench.topic} is in the frame {self._frame}, the profile says {profile.frames.sensor}: "
                "the readings are marked invalid"
            )
        if self._gravity.line:
            yield self._gravity.line

    def _take(self, heard: Heard[Joints], now: int) -> bool:
        names = heard.message.names
        if self._names and names != self._names and sorted(names) == sorted(self._names):
            self._reordered = self._now
        self._names = names
        if self.state.take(heard, now):
            return True
        if not self.state.absent:
            self._leapt = self._now
        return False
