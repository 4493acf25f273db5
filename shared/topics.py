"""THE table of topics and queries. Bus, health, access control, documentation and command line are derived from it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Generic, TypeVar

from shared import messages as m
from shared.schema.records import Record
from shared.sim_messages import SimWorld
from shared.wire.codec import MAP_CAP

M = TypeVar("M", bound=Record)

ROBOT = "robot"
"""Publisher name of whatever process stands for the robot: the simulation or a hardware bridge."""
ANYBODY = "*"


@dataclass(frozen=True)
class Topic(Generic[M]):
    """One key.

    Attributes:
        key: without the robot's prefix.
        message: class of its messages.
        rate: nominal rate [Hz]; 0 = on change only.
        max_age: age [s] up to which a reader may use the last message; infinite = until replaced.
        publishers: the only services allowed to publish it, one at a time.
        cap: largest payload [bytes].
    """

    key: str
    message: type[M]
    rate: float
    max_age: float
    publishers: tuple[str, ...]
    cap: int = MAP_CAP

    @property
    def publisher(self) -> str:
        """Who publishes it, in words."""
        return " or ".join(self.publishers)


@dataclass(frozen=True)
class Query:
    """One queryable.

    Attributes:
        key: without the robot's prefix.
        server: the service that answers.
        request: the request's fields, for the reader.
        reply: the reply's fields besides ``ok``, for the reader.
    """

    key: str
    server: str
    request: str
    reply: str


SENSOR_FT = Topic("sensor/ft", m.FtSample, 100, 0.03, (ROBOT,))
SENSOR_CAMERA = Topic("sensor/camera", m.CameraImage, 10, 0.5, (ROBOT,), cap=4 * 1024 * 1024)
STATE_JOINTS = Topic("state/joints", m.JointState, 100, 0.1, (ROBOT,))
STATE_EE = Topic("state/ee", m.EndEffector, 100, 0.1, (ROBOT,))
STATE_BASE = Topic("state/base", m.BaseState, 50, 0.2, (ROBOT,))
STATE_GRIPPER = Topic("state/gripper", m.GripperState, 20, 0.5, (ROBOT,))
STATE_ROBOT = Topic("state/robot", m.RobotStatus, 5, 1.0, (ROBOT,))

COMMAND_EE_TWIST = Topic("command/ee_twist", m.TwistCommand, 100, 0.05, ("controller",))
COMMAND_BASE_TWIST = Topic("command/base_twist", m.BaseTwistCommand, 100, 0.1, ("base",))
COMMAND_GRIPPER = Topic("command/gripper", m.GripperCommand, 0, math.inf, ("task",))
COMMAND_HEAD = Topic("command/head", m.HeadCommand, 0, math.inf, ("task",))
STOP = Topic("stop", m.Stop, 0, math.inf, (ANYBODY,))

WRENCH_EXTERNAL = Topic("wrench/external", m.ExternalWrench, 100, 0.03, ("wrench",))
CONTROL_TARGET = Topic("control/target", m.ControlTarget, 5, math.inf, ("task", "experiment"))
CONTROL_STATUS = Topic("control/status", m.ControlStatus, 100, 1.0, ("controller",))
BASE_STATUS = Topic("base/status", m.BaseStatus, 100, 1.0, ("base",))
BASE_ENABLE = Topic("base/enable", m.Enable, 5, 1.0, ("task",))
TASK_STATUS = Topic("task/status", m.TaskStatus, 5, 1.0, ("task",))
SIM_WORLD = Topic("sim/world", SimWorld, 30, 0.5, (ROBOT,))

TOPICS: tuple[Topic, ...] = (
    SENSOR_FT,
    SENSOR_CAMERA,
    STATE_JOINTS,
    STATE_EE,
    STATE_BASE,
    STATE_GRIPPER,
    STATE_ROBOT,
    COMMAND_EE_TWIST,
    COMMAND_BASE_TWIST,
    COMMAND_GRIPPER,
    COMMAND_HEAD,
    STOP,
    WRENCH_EXTERNAL,
    CONTROL_TARGET,
    CONTROL_STATUS,
    BASE_STATUS,
    BASE_ENABLE,
    TASK_STATUS,
    SIM_WORLD,
)

WRENCH_TARE = Query(
    "wrench/tare",
    "wrench",
    "`duration` s (default 1)",
    "`force`[3] N, `torque`[3] Nm: bias in sensor axes; `samples`; `std`[6]",
)
WRENCH_IDENTIFY = Query(
    "wrench/identify",
    "wrench",
    '`action` "start", "add", "solve" or "cancel"',
    "solve: `mass` kg, `com`[3] m in sensor axes, `force_bias`[3], `torque_bias`[3], `sigma`, `residual_rms`[6], "
    "`condition`, "
    "`file` where it was written, empty if nowhere",
)
TASK_COMMAND = Query("task/command", "task", '`command` "start", "abort", "release" or "reset"', "`state`")
_PARAMETERS = (
    "`set` {name: value}, or nothing",
    "`parameters` {name: {`value`, `unit`, `min`, `max`, `doc`}}",
)
WRENCH_PARAMETERS = Query("wrench/parameters", "wrench", *_PARAMETERS)
CONTROL_PARAMETERS = Query("control/parameters", "controller", *_PARAMETERS)
BASE_PARAMETERS = Query("base/parameters", "base", *_PARAMETERS)
SIM_COMMAND = Query(
    "sim/command",
    ROBOT,
    '`command` "reset"; "load" {`mass` kg}; "push" {`force`[3], `torque`[3], `duration` s}; '
    '"hand" {`script` name or TOML, or `target`[3] m in world}; "cover_marker" {`covered` bool, default true}; '
    '"fault" {`target`, `kind`, `value`}; '
    "simulation only",
    "nothing",
)

QUERIES = (
    WRENCH_TARE,
    WRENCH_IDENTIFY,
    TASK_COMMAND,
    WRENCH_PARAMETERS,
    CONTROL_PARAMETERS,
    BASE_PARAMETERS,
    SIM_COMMAND,
)
PARAMETER_QUERIES = (WRENCH_PARAMETERS, CONTROL_PARAMETERS, BASE_PARAMETERS)

HEALTH_RATE = 2.0


def health_topic(service: str) -> Topic[m.Health]:
    """The health of one service."""
    return Topic(f"health/{service}", m.Health, HEALTH_RATE, 1.0, (service,))


def topic_by_key(key: str) -> Topic | None:
    """The topic of a key without the robot's prefix, or None."""
    if key.startswith("health/"):
        return health_topic(key.removeprefix("health/"))
    return next((topic for topic in TOPICS if topic.key == key), None)
