"""The tables of a robot's profile: what each field means, its unit and its range."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

from shared.robot.base_gate import BaseLimits
from shared.spatial import Array, quaternion_from_rpy, rotation_matrix

Middleware = Literal["ros1", "ros2"]

Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$")]
TopicName = Annotated[str, Field(pattern=r"^(/[A-Za-z][A-Za-z0-9_]*)+$")]
# TOML has lists only; what is not to change is a tuple.
_LIST = BeforeValidator(lambda value: tuple(value) if isinstance(value, list) else value)
Names = Annotated[tuple[Name, ...], _LIST, Field(min_length=1)]
Numbers = Annotated[tuple[NotNegative, ...], _LIST]
Three = Annotated[tuple[float, float, float], _LIST]
Six = Annotated[tuple[Positive, Positive, Positive, Positive, Positive, Positive], _LIST]
Range = Annotated[tuple[float, float], _LIST]


class Table(BaseModel):
    """A table of the file."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)


class Frames(Table):
    """Links of the description: the root, what is commanded, where the wrist's sensor measures, the camera's optics."""

    base: str
    tool: str
    sensor: str
    camera: str = ""


class Lift(Table):
    """A joint that goes up and down with the tool, so that the arm need not: all the way down at a tool's height."""

    joint: Name
    bottom: float
    lowest_tool: float


class Arm(Table):
    """The joints that move the tool, from the base outwards, and numbers of each of them.

    Attributes:
        acceleration: that it can always reach [rad/s2, m/s2].
        home: posture [rad, m] that the redundancy is drawn to; where the arm was at the start if there is none.
        weight: cost of its speed relative to others' [1]; all 1 if not given.
        margin: distance [rad, m] from its limits at which it stands still.
        speed: largest [rad/s, m/s]; the description's if not given.
    """

    joints: Names
    acceleration: Numbers
    home: Annotated[tuple[float, ...], _LIST] = ()
    weight: Numbers = ()
    margin: Numbers = ()
    speed: Numbers = ()
    lift: Lift | None = None


class Stream(Table):
    """A topic of measurements at a rate [Hz]."""

    topic: TopicName
    rate: Positive


class WrenchStream(Stream):
    """The wrist's sensor, uncompensated.

    Attributes:
        sign: 1 if it tells what the environment exerts on the robot, -1 if the opposite.
        rotation: roll, pitch, yaw [rad] of the axes it is told in, in the sensor frame.
        saturation: readings [N, Nm] per axis at which it is at the end of its range.
    """

    sign: Literal[1, -1] = 1
    rotation: Three = (0.0, 0.0, 0.0)
    saturation: Six

    @property
    def axes(self) -> Array:
        """Rotation (3, 3) of what is told into the sensor frame, sign included: times a reading gives the force."""
        return self.sign * rotation_matrix(quaternion_from_rpy(*self.rotation))


class Controller(Table):
    """A trajectory controller: its topic of commands, its joints, and what the controller manager calls it."""

    topic: TopicName
    joints: Names
    controller: Name


class Head(Table):
    """Pan and tilt, by a table of [controllers]."""

    controller: Name
    joints: Annotated[tuple[Name, Name], _LIST]


class Gripper(Table):
    """Fingers, by a table of [controllers].

    Attributes:
        joints: the fingers', each of which goes half the opening.
        opening: least and largest [m] between the fingers.
        effort: least and largest [N].
        speed: of the opening [m/s].
        caught: distance [m] of the opening from where it is to close to, above which something is between the fingers.
    """

    controller: Name
    joints: Annotated[tuple[Name, Name], _LIST]
    opening: Range
    effort: Range
    speed: Positive = 0.05
    caught: Positive = 0.004


class Base(Table):
    """The mobile base.

    Attributes:
        topic: an input of twist_mux, or the base's own.
        type: of its messages: geometry_msgs' Twist or TwistStamped.
        odometry: topic.
        rate: of the odometry [Hz].
        timeout: [s] after the last command at which the robot itself halts the base.
        forwards, backwards, sideways, turning, acceleration, angular_acceleration, together: as ``BaseLimits``.
    """

    topic: TopicName
    type: str
    odometry: TopicName
    rate: Positive = 50.0
    timeout: Positive
    forwards: NotNegative
    backwards: NotNegative
    sideways: NotNegative = 0.0
    turning: NotNegative
    acceleration: Positive
    angular_acceleration: Positive
    together: Mapping[Annotated[str, Field(pattern="^(xy|xz|yz|xyz)$")], Annotated[float, Field(gt=0, le=1)]] = {}

    def limits(self, scale: float = 1.0) -> BaseLimits:
        """Limits of its gate, ``scale`` [1] times what the profile says."""
        return BaseLimits(
            scale * self.forwards,
            scale * self.backwards,
            scale * self.sideways,
            scale * self.turning,
            self.acceleration,
            self.angular_acceleration,
            self.together,
        )


class Camera(Table):
    """The camera: topics of images and of their calibration, rate [Hz], and the encoding that is expected."""

    image: TopicName
    info: TopicName
    rate: Positive
    encoding: Literal["rgb8", "bgr8", "mono8"] = "rgb8"


class EmergencyStop(Table):
    """Topic that tells whether the emergency stop is pressed.

    Attributes:
        type: std_msgs' Bool.
        latched: whether late subscribers get the last message, so that without one it is released.
        pressed: the value that means pressed.
    """

    topic: TopicName
    type: str
    latched: bool = True
    pressed: bool = True


class EnableDevice(Table):
    """Topic of a hold-to-run device: std_msgs' Bool, or sensor_msgs' Joy with the number of the button."""

    topic: TopicName
    type: str
    button: Annotated[int, Field(ge=0)] = 0


class Switching(Table):
    """Service of the controller manager, and the controllers to start, and to stop instead, while the bridge runs."""

    service: TopicName
    start: Annotated[tuple[Name, ...], _LIST] = ()
    stop: Annotated[tuple[Name, ...], _LIST] = ()
