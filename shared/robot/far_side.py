"""The robot's own side of a bridge, in the robot's own words and with no word of how they travel.

A bridge is a `FarSide`, which speaks the robot's middleware, and what all bridges share: the gate, the kinematics and
the watch over what the robot says (``shared.robot.bridge``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

from shared.spatial import Array

T_co = TypeVar("T_co", covariant=True)


@dataclass(frozen=True, slots=True)
class Heard(Generic[T_co]):
    """The newest message of one kind.

    Attributes:
        message: what it says, checked: of the right shape, every number finite.
        number: messages of this kind so far, this one included.
        arrival: [ns] of this process' steady clock.
        stamp: [ns] of the robot's clock; None where its message has none.
        sender: who published it, as the middleware names publishers; empty if it does not say.
    """

    message: T_co
    number: int
    arrival: int
    stamp: int | None
    sender: str


@dataclass(frozen=True, slots=True)
class Joints:
    """Names, and positions [rad, m], velocities and efforts [Nm, N] in their order."""

    names: tuple[str, ...]
    position: Array
    velocity: Array
    effort: Array


@dataclass(frozen=True, slots=True)
class Wrench:
    """Force (3,) [N] and torque (3,) [Nm] with the signs and in the frame of the robot."""

    force: Array
    torque: Array
    frame: str


@dataclass(frozen=True, slots=True)
class Odometry:
    """Position (2,) [m] and yaw [rad] in the odometry's frame, velocity (3,) vx, vy [m/s], wz [rad/s] in the base's."""

    position: Array
    yaw: float
    velocity: Array


@dataclass(frozen=True, slots=True)
class Picture:
    """An image, encoded as the contract names encodings."""

    width: int
    height: int
    encoding: str
    data: bytes


@dataclass(frozen=True, slots=True)
class Calibration:
    """Intrinsics (4,) fx, fy, cx, cy [px] and distortion of images of that size; the model as ROS names it."""

    width: int
    height: int
    intrinsics: Array
    distortion: Array
    model: str


@dataclass(frozen=True, slots=True)
class TrajectoryPoint:
    """Where joints are to be, positions (n,) [rad, m] and velocities (n,), so long [s] after the message arrives."""

    after: float
    position: Array
    velocity: Array


class FarSide(Protocol):
    """The robot as a bridge meets it. Every method returns at once; none raises for what the robot does."""

    def joints(self) -> Heard[Joints] | None:
        """The newest joint states."""
        ...

    def wrench(self) -> Heard[Wrench] | None:
        """The newest sample of the wrist's sensor."""
        ...

    def odometry(self) -> Heard[Odometry] | None:
        """The newest odometry; None where the profile has no base."""
        ...

    def picture(self, wanted: bool) -> tuple[Heard[Picture], Heard[Calibration]] | None:
        """The newest image and calibration; while it is not ``wanted`` nobody need subscribe to it."""
        ...

    def emergency(self) -> str:
        """Who says that the robot's emergency stop is pressed, by name; empty if nobody does."""
        ...

    def pressed(self) -> Heard[bool] | None:
        """Whether the enabling device that the profile names is pressed."""
        ...

    def move(self, controller: str, points: Sequence[TrajectoryPoint]) -> None:
        """Give a trajectory to one of the profile's trajectory controllers, for all its joints in the profile's order.

        It replaces the one before at once, and its last point is at rest: what comes after it need not be sent.
        """
        ...

    def drive(self, velocity: Array) -> None:
        """Give the base a velocity (3,) vx, vy [m/s], wz [rad/s]."""
        ...

    def ready(self) -> str:
        """Why nothing of what is commanded would be carried out (a controller that does not run); empty if it would."""
        ...

    def mismatches(self) -> Sequence[str]:
        """How the robot's topics and types differ from the profile, one line each; asked about once a second."""
        ...

    def refusals(self) -> Mapping[str, str]:
        """By topic, how many of its messages were refused, and why the last one was."""
        ...

    def close(self) -> None:
        """Hand controllers back and leave the robot's network; called once, when the arm is at rest."""
        ...
