"""THE table of processes. Command line, configuration files, documentation and tests are derived from it or checked.

Whoever adds a process adds a row here and a folder in `services`. What a process publishes and answers stands in
`shared/topics.py`, under its `speaks_as`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from shared.topics import ROBOT

ON_THE_BUS = ("--robot", "{robot}", "--connect", "{endpoint}")
"""Options of a process that connects to the router."""


@dataclass(frozen=True)
class Process:
    """One kind of process, started with `python -m services.<name>`.

    Attributes:
        name: of its folder in `services`, of its health, liveliness token and table in a configuration file.
        does: what it is for, in one line.
        started: by `tandem up` "always", or "with" `--with NAME`; or only "by hand".
        image: stage of a container's image that has all it needs.
        extra: of pyproject.toml that it needs; empty if it needs none.
        speaks_as: its name among publishers and servers of `shared/topics.py`; the name itself if empty.
        lives_as: the name of its health, its liveliness token and its certificate; the name itself if empty.
        service: it runs the loop of `shared/loop`: liveliness token, health, `--config` with a table of its name.
        settable: it takes parameters, by `--set` and from its table.
        linked: it belongs to the chain, whose processes have direct links to each other.
        options: that it has to be started with; {robot}, {endpoint} and {folder} stand for what the caller chooses.
    """

    name: str
    does: str
    started: Literal["always", "with", "by hand"]
    image: str = "core"
    extra: str = ""
    speaks_as: str = ""
    lives_as: str = ""
    service: bool = True
    settable: bool = True
    linked: bool = False
    options: tuple[str, ...] = ON_THE_BUS

    @property
    def module(self) -> str:
        """Module for `python -m`."""
        return f"services.{self.name}"

    @property
    def publisher(self) -> str:
        """Its name in `shared/topics.py`."""
        return self.speaks_as or self.name

    @property
    def known_as(self) -> str:
        """The name of its health, its liveliness token and its certificate."""
        return self.lives_as or self.name

    def arguments(self, robot: str, endpoint: str, folder: str = ".") -> list[str]:
        """The command line that it needs at least.

        Args:
            robot: first chunk of every key.
            endpoint: of the router, which listens there itself.
            folder: for what it writes.
        """
        return [part.format(robot=robot, endpoint=endpoint, folder=folder) for part in self.options]


ROUTER = Process(
    "router",
    "Zenoh router; the only thing the others connect to",
    "always",
    service=False,
    settable=False,
    options=("--listen", "{endpoint}"),
)
SIM = Process(
    "sim",
    "simulated TIAGo: physics, onboard inverse kinematics, wrist sensor, base, gripper, head camera; a bag on a rope, "
    "a panel and a person; and the gate",
    "always",
    image="sim",
    extra="sim",
    speaks_as=ROBOT,
    linked=True,
)
MOCK = Process(
    "mock",
    "a robot without physics behind the gate: it does at once what it is told",
    "by hand",
    speaks_as=ROBOT,
    linked=True,
)
BRIDGE_ROS1 = Process(
    "bridge_ros1",
    "stands for a robot under ROS 1, melodic or noetic, as its profile describes it",
    "by hand",
    image="bridge_ros1",
    extra="bridge",
    speaks_as=ROBOT,
    lives_as=ROBOT,
    linked=True,
)
BRIDGE_ROS2 = Process(
    "bridge_ros2",
    "stands for a robot under ROS 2 as its profile describes it, over zenoh-bridge-ros2dds or rmw_zenoh",
    "by hand",
    image="bridge_ros2",
    extra="bridge_ros2",
    speaks_as=ROBOT,
    lives_as=ROBOT,
    linked=True,
)
ROS_ROBOT = Process(
    "ros_robot",
    "simulated TIAGo as ROS shows it, for a bridge to stand in front of: controllers, twist_mux, topics, and what is "
    "around it",
    "by hand",
    image="ros_robot",
    extra="ros_robot",
)
WRENCH = Process("wrench", "gravity compensation, error bound, sensor faults", "always", linked=True)
CONTROLLER = Process("controller", "the control laws", "always", image="controller", extra="controller", linked=True)
BASE = Process(
    "base", "moves the mobile base as a free-floating body under the wrench, while enabled", "with", linked=True
)
TASK = Process(
    "task",
    "the carry: finds and grasps the panel, says what to hold, lets go",
    "with",
    image="task",
    extra="task",
    linked=True,
)
EXPERIMENT = Process(
    "experiment",
    "plays a protocol against running processes, judges it, writes a report",
    "by hand",
    image="tools",
    extra="experiment",
    settable=False,
    options=("play", "load", "--run", "certified-100", "--out", "{folder}", *ON_THE_BUS),
)
RECORDER = Process(
    "recorder",
    "writes all that is said to the disk, in MCAP",
    "by hand",
    image="tools",
    extra="recorder",
    service=False,
    settable=False,
    options=(*ON_THE_BUS, "--out", "{folder}"),
)
VIEWER = Process(
    "viewer",
    "draws the robot, the forces and their limits in a browser, and says why the robot does what it does",
    "by hand",
    image="viewer",
    extra="viewer",
    service=False,
    settable=False,
    options=(*ON_THE_BUS, "--port", "0"),
)
CLI = Process(
    "cli", "the command `tandem`", "by hand", image="cli", extra="cli", service=False, settable=False, options=()
)

PROCESSES = (
    ROUTER,
    SIM,
    MOCK,
    BRIDGE_ROS1,
    BRIDGE_ROS2,
    ROS_ROBOT,
    WRENCH,
    CONTROLLER,
    BASE,
    TASK,
    EXPERIMENT,
    RECORDER,
    VIEWER,
    CLI,
)
"""In the order in which people are shown them."""
SERVICES = tuple(process.name for process in PROCESSES if process.service)
"""Whoever runs the loop of `shared/loop`, and has a table in a configuration file."""
STACK = tuple(process.name for process in PROCESSES if process.service and process.started == "always")
"""The services of every stack."""
ROBOTS = (*(process.name for process in PROCESSES if process.publisher == ROBOT), ROBOT)
"""The processes of which one stands for the robot: the last of them is whatever a real robot has."""
HEALTHY = tuple(dict.fromkeys((ROUTER.name, *(process.known_as for process in PROCESSES if process.service), ROBOT)))
"""Whoever may tell a health; the router does on a closed network."""
LINKED = tuple(dict.fromkeys(process.publisher for process in PROCESSES if process.linked))
"""Names in `shared/topics.py` of the processes of the chain."""
FURTHER = tuple(process.name for process in PROCESSES if process.started == "with")
"""The services that a stack has if it is told so."""


def same_kind(name: str) -> tuple[str, ...]:
    """Names of all processes of which one at a time may run for a robot, given one of them."""
    return ROBOTS if name in ROBOTS else (name,)


def publisher_named(name: str) -> str:
    """What a process is called in `shared/topics.py`, given its own name."""
    return ROBOT if name in ROBOTS else name


def speakers(publisher: str) -> tuple[str, ...]:
    """Names of the processes that speak as a publisher of `shared/topics.py`."""
    return ROBOTS if publisher == ROBOT else (publisher,)


def process_named(name: str) -> Process:
    """The row of a name; KeyError if there is none."""
    return {process.name: process for process in PROCESSES}[name]
