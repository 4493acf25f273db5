"""The messages of the Zenoh contract, version 1: one class each, with unit, shape and frame of every field.

Unless a field says otherwise it is expressed in the axes of ``base`` (the robot's ``base_footprint``). Twists are those
of the tool's origin relative to ``base``; wrenches are what the environment exerts on the robot. The header is not part
of a message: the publisher's framework adds it.
"""

from __future__ import annotations

import numpy as np

from shared.schema.fields import (
    Boolean,
    Bytes,
    Direction,
    Integer,
    InvalidField,
    Number,
    Quaternion,
    Text,
    TextList,
    Vector,
)
from shared.schema.records import MapOf, Nullable, Record, RecordOf, of

LONGEST_TTL = 0.2
"""No command is executed for longer than this [s] after its publication, whatever its ``ttl`` says."""
_TTL = f"at most {LONGEST_TTL:g}: a longer one counts as that"
DISTORTION_SIZES = (0, 4, 5, 8)
"""Numbers of coefficients with which OpenCV describes a lens that is no fisheye, but for its rarest models."""
_ZERO3 = (0.0, 0.0, 0.0)


class Header(Record):
    """Header of every published message, besides its fields."""

    seq: int = of(Integer(minimum=0, doc="+1 per message of one publisher"))
    session: int = of(Integer(doc="random, drawn once per start of the publisher"))
    stamp: int = of(Integer(unit="ns", doc="publisher's steady clock, any epoch"))
    valid: bool = of(Boolean(doc="every input that went into the message was healthy"))


class FtSample(Record):
    """One reading of the wrist's force-torque sensor, uncompensated."""

    force: np.ndarray = of(Vector("N", "sensor axes"))
    torque: np.ndarray = of(Vector("Nm", "about the sensor's origin, sensor axes"))
    orientation: np.ndarray = of(Quaternion("", "sensor in base at that instant"))
    tool_offset: np.ndarray = of(Vector("m", "tool origin from the sensor's origin, sensor axes"))
    saturated: bool = of(Boolean(doc="some axis is at the end of its range"))
    gravity: np.ndarray = of(
        Direction("", "of gravity in base axes at that instant, by the robot's own tilt sensor"),
        default=(0.0, 0.0, -1.0),
    )

    def check(self) -> None:
        if (z := float(self.gravity[2])) > -0.5:
            raise InvalidField(
                f"gravity has z {z:.2f}, wanted at most -0.5: where things fall, in base axes, within 60 degrees of -z"
            )


class CameraImage(Record):
    """One image of the head camera with its calibration and pose."""

    width: int = of(Integer("px", minimum=1))
    height: int = of(Integer("px", minimum=1))
    encoding: str = of(Text(choices=("jpeg", "png", "rgb8", "bgr8", "mono8")))
    data: bytes = of(Bytes())
    intrinsics: np.ndarray = of(Vector("px", "fx, fy, cx, cy of this very image, cropped and scaled as it is", size=4))
    distortion: np.ndarray = of(
        Vector(
            "",
            "none (or zeros: a rectified image), or 4, 5 or 8 of k1, k2, p1, p2, k3, k4, k5, k6 as OpenCV orders them",
            size=None,
        )
    )
    position: np.ndarray = of(Vector("m", "optical frame in base"))
    orientation: np.ndarray = of(Quaternion("", "optical frame (z forward, x right) in base"))
    distortion_model: str = of(
        Text(doc="as ROS names it, empty if not told; a fisheye's coefficients (equidistant) are of another model"),
        default="",
    )

    def check(self) -> None:
        if (count := len(self.distortion)) not in DISTORTION_SIZES:
            allowed = ", ".join(map(str, DISTORTION_SIZES))
            raise InvalidField(f"distortion has {count} elements, wanted one of {allowed}, in OpenCV's order")


class JointState(Record):
    """Joint names, positions [rad, m], velocities and efforts [Nm, N], all of one length."""

    name: tuple[str, ...] = of(TextList())
    position: np.ndarray = of(Vector("rad or m", size=None))
    velocity: np.ndarray = of(Vector("rad/s or m/s", size=None))
    effort: np.ndarray = of(Vector("Nm or N", size=None))

    def check(self) -> None:
        for field in ("position", "velocity", "effort"):
            if (size := len(getattr(self, field))) != len(self.name):
                raise InvalidField(f"{field} has {size} elements, wanted one for each of {len(self.name)} names")


class EndEffector(Record):
    """Pose and twist of the tool."""

    position: np.ndarray = of(Vector("m"))
    orientation: np.ndarray = of(Quaternion())
    linear: np.ndarray = of(Vector("m/s"))
    angular: np.ndarray = of(Vector("rad/s"))


class BaseState(Record):
    """Odometry of the base."""

    position: np.ndarray = of(Vector("m", size=2))
    yaw: float = of(Number("rad"))
    velocity: np.ndarray = of(Vector("m/s, m/s, rad/s", "vx, vy, wz"))


class GripperState(Record):
    """The controlled gripper."""

    opening: float = of(Number("m"))
    effort: float = of(Number("N"))
    holding: bool = of(Boolean())


class RobotStatus(Record):
    """State of the robot's gate, and abilities of the robot."""

    mode: str = of(Text(choices=("ready", "holding", "stopped")))
    reason: str = of(Text())
    base_type: str = of(Text(choices=("differential", "omni")))
    simulated: bool = of(Boolean())
    max_linear: float = of(Number("m/s", minimum=0.0))
    max_angular: float = of(Number("rad/s", minimum=0.0))
    max_base: np.ndarray = of(
        Vector("m/s, m/s, rad/s", "vx forwards, vy, wz, each alone; backwards or together maybe less: see `reason`")
    )
    held: int = of(Integer(minimum=0, doc="motions of the tool broken off for want of a fresh command"), default=0)
    require_enable: bool = of(Boolean(doc="it moves only while the enabling device is pressed"), default=False)


class TwistCommand(Record):
    """Commanded tool twist; older than ``ttl`` it is not executed any more."""

    linear: np.ndarray = of(Vector("m/s"))
    angular: np.ndarray = of(Vector("rad/s"))
    ttl: float = of(Number("s", _TTL, above=0.0), default=0.05)


class BaseTwistCommand(Record):
    """Commanded base twist."""

    velocity: np.ndarray = of(Vector("m/s, m/s, rad/s", "vx, vy, wz"))
    ttl: float = of(Number("s", _TTL, above=0.0), default=0.1)


class GripperCommand(Record):
    """Wanted opening and the effort to use for it; not carried out once it is older than 1 s."""

    opening: float = of(Number("m", minimum=0.0))
    effort: float = of(Number("N", minimum=0.0))


class HeadCommand(Record):
    """Wanted head joints; not carried out once they are older than 1 s."""

    pan: float = of(Number("rad"))
    tilt: float = of(Number("rad"))


class Stop(Record):
    """Latched by the gate; released only by ``engaged`` false."""

    engaged: bool = of(Boolean())
    reason: str = of(Text(longest=200, doc="the first 200 characters count"), default="")


class EnableDevice(Record):
    """The person's hold-to-run device; silence means that it is let go."""

    pressed: bool = of(Boolean())


class ExternalWrench(Record):
    """Wrench that the environment exerts on the tool, compensated, with a bound on its error."""

    force: np.ndarray = of(Vector("N"))
    torque: np.ndarray = of(Vector("Nm", "about the tool's origin"))
    error_bound: np.ndarray = of(Vector("N, Nm", "noise, bias and compensation residual", size=6, minimum=0.0))
    compensation: str = of(Text(choices=("none", "tare", "payload")))
    fault: str = of(Text(doc="empty, or silent, stuck, saturated, invalid"))
    zero_age: float | None = of(
        Nullable(
            "s",
            "since the tare or identification of this run of the robot; -1 without one, null if not told",
            kind=Number(minimum=-1.0),
        ),
        default=None,
    )


class ControlTarget(Record):
    """Pose to hold and limits to keep; the limits are centred on the nominal wrench."""

    position: np.ndarray = of(Vector("m"))
    orientation: np.ndarray = of(Quaternion())
    force_limit: np.ndarray = of(Vector("N", above=0.0))
    torque_limit: np.ndarray = of(Vector("Nm", above=0.0))
    nominal_force: np.ndarray = of(Vector("N"), default=_ZERO3)
    nominal_torque: np.ndarray = of(Vector("Nm"), default=_ZERO3)


class ControlStatus(Record):
    """State of the controller, with the reason."""

    state: str = of(Text(choices=("waiting", "tracking", "yielding", "braking")))
    reason: str = of(Text())
    law: str = of(Text(choices=("certified", "paper", "stiffness")))
    twist: np.ndarray = of(Vector("m/s, rad/s", "as commanded", size=6))
    margin: np.ndarray = of(Vector("N, Nm", "limit in force - abs(w - nominal) - error_bound", size=6))
    active: np.ndarray = of(Vector("", "-1, 0 or 1: which bound is active", size=6))
    relaxation: float = of(Number("", "gamma"))
    lyapunov: float = of(Number("", "V"))
    solve_us: float = of(Number("us"))
    limit: np.ndarray | None = of(
        Nullable(
            "N, Nm",
            "6 numbers, in force in this tick: `margin` and `active` count against them; 0 without a target",
            kind=Vector(size=6, minimum=0.0),
        ),
        default=None,
    )
    nominal: np.ndarray | None = of(
        Nullable("N, Nm", "6 numbers, in force in this tick: the limits are centred on it", kind=Vector(size=6)),
        default=None,
    )


class BaseStatus(Record):
    """State of the base's admittance."""

    state: str = of(Text(choices=("off", "following", "braking")))
    wrench: np.ndarray = of(Vector("N, N, Nm", "fx, fy, tz about the base's origin"))
    velocity: np.ndarray = of(Vector("m/s, m/s, rad/s"))


class Enable(Record):
    """Silence over a second means disabled."""

    enabled: bool = of(Boolean())


class MarkerPose(Record):
    """A detected marker."""

    position: np.ndarray = of(Vector("m"))
    orientation: np.ndarray = of(Quaternion())
    age: float = of(Number("s", minimum=0.0))


class TaskStatus(Record):
    """Where the carrying task stands."""

    state: str = of(Text())
    since: float = of(Number("s", minimum=0.0))
    reason: str = of(Text())
    rotation: float = of(Number("rad", "about the tool's x axis since the grasp"))
    height: float = of(Number("m", "of the tool"))
    marker: MarkerPose | None = of(Nullable(kind=RecordOf(record=MarkerPose)))


class InputHealth(Record):
    """One input as its reader sees it; ``age`` is -1 before the first message."""

    age: float = of(Number("s"))
    hz: float = of(Number("Hz", minimum=0.0))
    rejected: int = of(Integer(minimum=0))
    ok: bool = of(
        Boolean(doc="fresh and valid; also: optional and nothing received, or on change only and not refused")
    )


class Health(Record):
    """How a service is."""

    state: str = of(Text(choices=("starting", "ok", "degraded", "fault")))
    detail: str = of(Text())
    loop_hz: float = of(Number("Hz", minimum=0.0))
    loop_p50_us: float = of(Number("us", minimum=0.0))
    loop_p99_us: float = of(Number("us", minimum=0.0))
    overruns: int = of(Integer(minimum=0))
    inputs: dict[str, InputHealth] = of(MapOf(kind=RecordOf(record=InputHealth)))
    links: dict[str, bool] = of(
        MapOf(doc="by name of a process: whether the direct link that the service needs is there", kind=Boolean()),
        default={},
    )
