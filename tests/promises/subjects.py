"""What each process needs to keep its promises in front of a test: a row for each row of the table of processes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

from services.experiment.play.observation import INPUTS as WATCHED
from shared import topics as t
from shared.processes import Process as Row
from shared.processes import process_named
from shared.robot.side import RobotSide
from shared.topics import Query, Topic
from tests.promises import worlds
from tests.support import ros1, ros2
from tests.support.processes import Process

if TYPE_CHECKING:
    from tests.promises.surroundings import Surroundings

Judge = Callable[[Any], bool]
Behind = Callable[[Callable[..., Process], str], Mapping[str, str]]


@dataclass(frozen=True, eq=False)
class Subject:
    """One process and what it needs.

    Attributes:
        name: of its row in the table of processes.
        output: by which it is seen whether it works; None if it says nothing on the bus.
        works, rests: whether a message of its output is what it is there for, or moves nothing.
        last_word: the topic on which it says that it ends, if that is not its output.
        sound: by topic, what holds for every message that it ever says, given the one before it.
        world: what the others say around it.
        required: inputs without which it does not work.
        optional: its other inputs.
        lacks: what others publish and answer under the same name, and it does not.
        settings: with which it is started here: a shared machine holds processes up for longer than a robot's.
        slower: rates [Hz] of topics that come less often from it than is usual.
        begin: makes it work, if its inputs alone do not.
        latches: a failure of the sensor keeps it at rest until somebody releases it.
        parameter: a name with a value that it takes and one that it refuses, with what it says then.
        in_force: whether the value that it takes is.
        behind: starts what has to be there besides the router at an endpoint, and says how the process'
            environment names it; skips the test where that cannot be.
    """

    name: str
    output: Topic | None = None
    works: Judge = lambda message: True
    rests: Judge = lambda message: True
    last_word: Topic | None = None
    sound: Mapping[Topic, Callable[[Any, Any], bool]] = field(default_factory=dict)
    world: worlds.World = worlds.nobody
    required: tuple[Topic, ...] = ()
    optional: tuple[Topic, ...] = ()
    lacks: tuple[Topic | Query, ...] = ()
    settings: tuple[str, ...] = ()
    slower: Mapping[Topic, float] = field(default_factory=dict)
    begin: Callable[[Surroundings], None] = lambda around: None
    latches: bool = False
    parameter: tuple[str, Any, Any, str] | None = None
    in_force: Callable[[Surroundings], bool] = lambda around: True
    behind: Behind = lambda start, endpoint: {}

    def __repr__(self) -> str:
        return self.name

    @property
    def process(self) -> Row:
        """Its row."""
        return process_named(self.name)

    @property
    def inputs(self) -> tuple[Topic, ...]:
        """All inputs."""
        return (*self.required, *self.optional)

    @property
    def outputs(self) -> tuple[Topic, ...]:
        """All that it publishes without being asked for it."""
        said = (topic for topic in t.TOPICS if self.process.publisher in topic.publishers)
        unasked = (topic for topic in said if topic is not t.SENSOR_CAMERA and topic not in self.lacks)
        of_itself = t.own_topics(self.process.known_as) if self.process.service else (t.health_topic(self.name),)
        return (*unasked, *of_itself)

    @property
    def queries(self) -> tuple[Query, ...]:
        """All that it answers."""
        served = (query for query in t.QUERIES if self.process.publisher in query.servers)
        return tuple(query for query in served if query not in self.lacks)

    def arguments(self, endpoint: str, folder: str) -> list[str]:
        """Its command line."""
        chosen = [f"--set={setting}" for setting in self.settings]
        return [*self.process.arguments("tiago", endpoint, folder), *chosen]


_ROBOT: dict[str, Any] = {
    "output": t.STATE_ROBOT,
    "works": lambda status: status.mode == "ready",
    "rests": lambda status: status.mode != "ready",
    "sound": {t.STATE_ROBOT: lambda status, before: "clamped" not in status.reason},
    "optional": RobotSide.INPUTS,
    "world": worlds.commander,
}
_AS_TIAGO_TELLS = {t.STATE_EE: 50.0, t.STATE_JOINTS: 50.0}
_TROUBLE = ("restarted", "controller brakes", "of no use", "cannot be read")

SUBJECTS = (
    Subject("router"),
    Subject("sim", **_ROBOT),
    Subject("mock", **_ROBOT, lacks=(t.SIM_WORLD, t.SIM_COMMAND)),
    Subject(
        "bridge_ros1",
        **_ROBOT,
        lacks=(t.SIM_WORLD, t.SIM_COMMAND),
        settings=("require_enable=false",),
        slower=_AS_TIAGO_TELLS,
        begin=worlds.release,
        behind=partial(ros1.robot, name="behind_ros1"),
    ),
    Subject(
        "bridge_ros2",
        **_ROBOT,
        lacks=(t.SIM_WORLD, t.SIM_COMMAND),
        settings=("require_enable=false", 'dialect="rmw_zenoh"'),
        slower=_AS_TIAGO_TELLS,
        begin=worlds.release,
        behind=partial(ros2.robot, name="behind_ros2"),
    ),
    Subject("ros_robot", output=t.SIM_WORLD, settings=('transport="none"',)),
    Subject(
        "wrench",
        output=t.WRENCH_EXTERNAL,
        works=lambda wrench: wrench.fault == "",
        rests=lambda wrench: wrench.fault != "",
        sound={t.WRENCH_EXTERNAL: lambda wrench, before: max(*abs(wrench.force), *abs(wrench.torque)) < 50.0},
        world=worlds.sensor,
        required=(t.SENSOR_FT,),
        settings=("max_delay=0.1",),
        parameter=("lowpass_hz", 20.0, -1.0, r"lowpass_hz is -1.*0 to 1000 Hz"),
    ),
    Subject(
        "controller",
        output=t.COMMAND_EE_TWIST,
        works=lambda command: command.linear[0] > 0.0,
        rests=lambda command: not command.linear.any(),
        sound={
            t.COMMAND_EE_TWIST: lambda command, before: 0.0 <= command.linear[0] <= 0.25 + 1e-9,
            t.CONTROL_STATUS: lambda status, before: status.state == "braking" or status.margin[0] >= 0.0,
        },
        world=worlds.target,
        required=(t.WRENCH_EXTERNAL, t.STATE_EE),
        optional=(t.CONTROL_TARGET, t.STOP),
        settings=("delay=0.1", "period=0.1"),
        latches=True,
        parameter=("law", "paper", "pid", "certified"),
        in_force=lambda around: around.said(t.CONTROL_STATUS).law == "paper",
    ),
    Subject(
        "base",
        output=t.COMMAND_BASE_TWIST,
        works=lambda command: command.velocity[0] > 0.05,
        rests=lambda command: not command.velocity.any(),
        sound={
            # Within its speed, and never faster by more than its acceleration allows within the longest dt.
            t.COMMAND_BASE_TWIST: lambda command, before: (
                0.0 <= command.velocity[0] <= min(0.4, before.velocity[0] + 0.7 * 0.1) + 1e-9
            ),
            t.BASE_STATUS: lambda status, before: status.wrench[0] in (0.0, 6.0),
        },
        world=worlds.push,
        required=(t.WRENCH_EXTERNAL, t.STATE_EE, t.STATE_ROBOT),
        optional=(t.BASE_ENABLE, t.STOP),
        settings=("max_delay=0.2",),
        latches=True,
        parameter=("max_linear", 0.1, 1000.0, r"max_linear is 1000.*0\.01 to 1 m/s"),
        in_force=lambda around: abs(around.said(t.COMMAND_BASE_TWIST).velocity[0] - 0.1) < 1e-3,
    ),
    Subject(
        "task",
        output=t.TASK_STATUS,
        works=lambda status: status.state == "searching" and "waiting" not in status.reason,
        rests=lambda status: status.state == "holding" or "waiting" in status.reason,
        last_word=t.BASE_ENABLE,
        sound={t.TASK_STATUS: lambda status, before: not any(word in status.reason for word in _TROUBLE)},
        world=worlds.stage,
        required=(t.STATE_EE,),
        optional=(t.STATE_GRIPPER, t.STATE_ROBOT, t.WRENCH_EXTERNAL, t.CONTROL_STATUS, t.STOP, t.SENSOR_CAMERA),
        settings=("max_delay=0.3", "patience=60.0", "search_patience=3600.0"),
        begin=worlds.search,
    ),
    Subject("experiment", output=t.CONTROL_TARGET, world=worlds.restless, optional=WATCHED),
    Subject("recorder"),
    Subject("viewer"),
    Subject("cli"),
)
BY_NAME = {subject.name: subject for subject in SUBJECTS}
SERVICES = tuple(subject for subject in SUBJECTS if subject.process.service)
"""Those that run the loop of ``shared/loop``."""
