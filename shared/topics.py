"""THE table of topics and queries. Bus, health, access control, documentation and command line are derived from it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Generic, NamedTuple, TypeVar

from shared import messages as m
from shared import requests as r
from shared import sim_messages as sim
from shared.requests import Nothing
from shared.schema.fields import InvalidField, Text
from shared.schema.records import Record

M = TypeVar("M", bound=Record)

ROBOT = "robot"
"""Publisher name of whatever process stands for the robot: the simulation or a hardware bridge."""
ROS_ROBOT = "ros_robot"
"""Publisher name of a simulated robot behind a bridge: all that it says here is what is true of its world."""
ANYBODY = "*"
OPERATOR = "operator"
"""Publisher name of the person's command line."""
PAGE = "page"
"""Publisher name of the person's page in the browser."""
LONGEST_REASON = 500
"""Longest reason [characters] of a refused query."""
MAP_CAP = 64 * 1024
"""Largest payload [bytes] of a query, and of every message that is not an image."""


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


class Exchange(NamedTuple):
    """A request, and its reply besides ``ok``."""

    request: type[Record]
    reply: type[Record] = Nothing


@dataclass(frozen=True, eq=False)
class Query:
    """One queryable.

    Attributes:
        key: without the robot's prefix.
        servers: the only services that may answer, one at a time.
        exchanges: what may be asked; by the request's field ``word``, if it has one that says which.
    """

    key: str
    servers: tuple[str, ...]
    exchanges: Mapping[str, Exchange]
    word: str = ""

    @property
    def server(self) -> str:
        """Who answers, in words."""
        return " or ".join(self.servers)

    def request(self, data: Mapping[str, Any]) -> Record:
        """The request of a decoded map.

        Raises:
            InvalidField: it asks for something else, or a field is missing or not of its kind.
        """
        return self._exchange(data).request.from_plain(data)

    def reply(self, request: Mapping[str, Any], data: Mapping[str, Any]) -> Record:
        """The reply of a decoded map to a request.

        Raises:
            InvalidField: a field is missing or not of its kind.
        """
        return self._exchange(request).reply.from_plain(data)

    def _exchange(self, data: Mapping[str, Any]) -> Exchange:
        if not self.word:
            return self.exchanges[""]
        if self.word not in data:
            raise InvalidField(f"{self.word} is missing, wanted one of {', '.join(self.exchanges)}")
        return self.exchanges[Text(choices=tuple(self.exchanges)).check(data[self.word], self.word)]


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
OPERATOR_ENABLE = Topic("operator/enable", m.EnableDevice, 20, 0.2, (OPERATOR, PAGE))

WRENCH_EXTERNAL = Topic("wrench/external", m.ExternalWrench, 100, 0.03, ("wrench",))
CONTROL_TARGET = Topic("control/target", m.ControlTarget, 5, math.inf, ("task", "experiment"))
CONTROL_STATUS = Topic("control/status", m.ControlStatus, 100, 1.0, ("controller",))
BASE_STATUS = Topic("base/status", m.BaseStatus, 100, 1.0, ("base",))
BASE_ENABLE = Topic("base/enable", m.Enable, 5, 1.0, ("task",))
TASK_STATUS = Topic("task/status", m.TaskStatus, 5, 1.0, ("task",))
SIM_WORLD = Topic("sim/world", sim.SimWorld, 30, 0.5, (ROBOT, ROS_ROBOT))

WRENCH_TARE = Query("wrench/tare", ("wrench",), {"": Exchange(r.Tare, r.Tared)})
WRENCH_IDENTIFY = Query(
    "wrench/identify",
    ("wrench",),
    {
        "start": Exchange(r.StartIdentification, r.Poses),
        "add": Exchange(r.AddPose, r.PoseAdded),
        "solve": Exchange(r.SolveIdentification, r.Solved),
        "cancel": Exchange(r.CancelIdentification, r.Poses),
    },
    word="action",
)
TASK_COMMAND = Query("task/command", ("task",), {"": Exchange(r.TaskCommand, r.TaskAnswer)})
_PARAMETERS = {"": Exchange(r.ParameterRequest, r.ParameterTable)}
WRENCH_PARAMETERS = Query("wrench/parameters", ("wrench",), _PARAMETERS)
CONTROL_PARAMETERS = Query("control/parameters", ("controller",), _PARAMETERS)
BASE_PARAMETERS = Query("base/parameters", ("base",), _PARAMETERS)
SIM_COMMAND = Query(
    "sim/command",
    (ROBOT, ROS_ROBOT),
    {
        "reset": Exchange(sim.Reset),
        "load": Exchange(sim.Load),
        "push": Exchange(sim.Push),
        "hand": Exchange(sim.Hand),
        "cover_marker": Exchange(sim.CoverMarker),
        "fault": Exchange(sim.SensorFault),
    },
    word="command",
)

TOPICS = tuple(value for value in list(globals().values()) if isinstance(value, Topic))
QUERIES = tuple(value for value in list(globals().values()) if isinstance(value, Query))
"""All that are declared above, in this order."""
PARAMETER_QUERIES = (WRENCH_PARAMETERS, CONTROL_PARAMETERS, BASE_PARAMETERS)

HEALTH_RATE = 2.0
SETUP_RATE = 1.0


def health_topic(service: str) -> Topic[m.Health]:
    """The health of one service."""
    return Topic(f"health/{service}", m.Health, HEALTH_RATE, 1.0, (service,))


def setup_topic(service: str) -> Topic[r.Setup]:
    """What one service works by."""
    return Topic(f"setup/{service}", r.Setup, SETUP_RATE, math.inf, (service,), cap=4 * MAP_CAP)


def own_topics(service: str) -> tuple[Topic, ...]:
    """What every service tells of itself."""
    return health_topic(service), setup_topic(service)


def topic_by_key(key: str) -> Topic | None:
    """The topic of a key without the robot's prefix, or None."""
    kind, _, service = key.partition("/")
    if service and kind == "health":
        return health_topic(service)
    if service and kind == "setup":
        return setup_topic(service)
    return next((topic for topic in TOPICS if topic.key == key), None)
