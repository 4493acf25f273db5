"""What the others say around a process: sound messages, steadily, and what a second publisher says."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING, Any

from shared import messages as m
from shared import topics as t
from shared.parameters import Refused
from shared.schema.records import Record
from shared.sim_messages import SimWorld
from shared.wire.bus import NoReply
from tests.services.task.robot import Robot
from tests.services.wrench.sensor import Sensor
from tests.support.wait import eventually

if TYPE_CHECKING:
    from tests.promises.surroundings import Surroundings

Says = Callable[[int], Iterable[tuple[t.Topic, Record]]]
"""What is published in the turn of a number, a hundred of which there are in a second."""
World = Callable[["Surroundings"], Says]

STILL, LEVEL = (0.0,) * 3, (0.0, 0.0, 0.0, 1.0)
SLOWLY = (0.001, 0.0, 0.0)
ERROR = (0.2, 0.2, 0.2, 0.02, 0.02, 0.02)
POSE = m.EndEffector((0.5, 0.0, 1.0), LEVEL, STILL, STILL)
PUSH = m.ExternalWrench((6.0, 0.0, -7.0), STILL, (0.2,) * 6, "tare", "")
READY = m.RobotStatus("ready", "", "omni", False, 0.3, 1.0, (1.0, 1.0, 2.0))

STRANGE: dict[t.Topic, dict[str, Any]] = {
    t.SENSOR_FT: {"force": [0.0, 0.0, 500.0]},
    t.SENSOR_CAMERA: {"data": b"no picture"},
    t.WRENCH_EXTERNAL: {"force": [-300.0, 0.0, 0.0]},
    t.STATE_EE: {"position": [9.0, 0.0, 1.0]},
    t.STATE_GRIPPER: {"holding": True},
    t.STATE_ROBOT: {"mode": "stopped"},
    t.CONTROL_TARGET: {"position": [-9.0, 0.0, 1.0]},
    t.CONTROL_STATUS: {"state": "braking"},
    t.BASE_ENABLE: {"enabled": False},
    t.BASE_STATUS: {"state": "braking"},
    t.TASK_STATUS: {"state": "done"},
    t.SIM_WORLD: {"marker_visible": False},
    t.COMMAND_EE_TWIST: {"linear": [9.0, 0.0, 0.0]},
    t.COMMAND_BASE_TWIST: {"velocity": [9.0, 0.0, 0.0]},
    t.COMMAND_GRIPPER: {"opening": 9.0},
    t.COMMAND_HEAD: {"pan": 9.0},
    t.OPERATOR_ENABLE: {"pressed": False},
}
"""Fields of a second publisher's messages: were they used, it would be seen in what is said of it."""


def steady(*rows: tuple[t.Topic, Record, int]) -> World:
    """The same messages again and again, each every so many turns; and at the start a release, which asks nothing."""

    def says(number: int) -> Iterator[tuple[t.Topic, Record]]:
        if number == 0:
            yield t.STOP, m.Stop(False)
        for topic, message, every in rows:
            if number % every == 0:
                yield topic, message

    return lambda around: says


def sensor(around: Surroundings) -> Says:
    """A wrist sensor with noise: one that repeats itself is stuck."""
    made_up = Sensor()
    return lambda number: [(t.SENSOR_FT, made_up.sample())]


def stage(around: Surroundings) -> Says:
    """A robot whose camera shows another marker than the one that the task looks for."""
    robot, start = Robot(around.client.watch), steady()(around)
    robot.number = 12
    return lambda number: [*start(number), *((topic, said) for topic, said, _ in robot.tick(number))]


def release(around: Surroundings) -> None:
    """Release the stop that a bridge starts with, once there is a robot behind it."""

    def works() -> bool:
        around.client.publish(t.STOP, m.Stop(False))
        return around.works()

    eventually(works, 60.0, lambda: f"released: {around.words}", every=0.5)


def search(around: Surroundings) -> None:
    """Start the task, from whatever state it is in."""

    def asked(word: str) -> bool:
        try:
            around.client.ask(t.TASK_COMMAND, {"command": word})
        except NoReply:
            return False
        except Refused as problem:
            if "`reset` first" in str(problem):
                asked("reset")
            return "at work already" in str(problem)
        return True

    eventually(lambda: asked("start"), 40.0, lambda: f"the task starts: {around.words}")


nobody = steady()
commander = steady(
    (t.COMMAND_EE_TWIST, m.TwistCommand(SLOWLY, STILL, 0.2), 1),
    (t.COMMAND_BASE_TWIST, m.BaseTwistCommand(SLOWLY, 0.2), 1),
    (t.COMMAND_GRIPPER, m.GripperCommand(0.05, 10.0), 20),
    (t.OPERATOR_ENABLE, m.EnableDevice(True), 5),
    (t.COMMAND_HEAD, m.HeadCommand(0.0, 0.0), 20),
)
target = steady(
    (t.STATE_EE, POSE, 1),
    (t.WRENCH_EXTERNAL, m.ExternalWrench(STILL, STILL, ERROR, "tare", ""), 1),
    (t.CONTROL_TARGET, m.ControlTarget((0.9, 0.0, 1.0), LEVEL, (10.0,) * 3, (3.0,) * 3), 10),
)
push = steady(
    (t.STATE_EE, POSE, 1), (t.WRENCH_EXTERNAL, PUSH, 1), (t.STATE_ROBOT, READY, 20), (t.BASE_ENABLE, m.Enable(True), 20)
)
restless = steady(
    # A tool that never comes to rest: no run of an experiment begins.
    (t.STATE_EE, m.EndEffector((0.5, 0.0, 1.0), LEVEL, (0.5, 0.0, 0.0), STILL), 1),
    (t.WRENCH_EXTERNAL, PUSH, 1),
    (t.CONTROL_STATUS, m.ControlStatus("tracking", "", "certified", *[(0.0,) * 6] * 3, 0.0, 0.0, 50.0), 1),
    (t.STATE_ROBOT, READY, 20),
    (t.BASE_STATUS, m.BaseStatus("off", STILL, STILL), 20),
    (t.TASK_STATUS, m.TaskStatus("idle", 0.0, "", 0.0, 0.0, None), 20),
    (t.SIM_WORLD, SimWorld(0.0, None, None, None, STILL, True), 20),
)
