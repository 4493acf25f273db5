"""The check passes a robot that keeps the contract, and names each defect of one that does not, in simulated time."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from services.cli.check import listening, moving, weighing
from services.cli.check.bench import Bench
from services.cli.check.gating import Gates
from services.cli.check.rows import Row
from services.mock.parameters import MockParameters
from services.mock.robot import MockRobot
from shared.loop.stack import Stack
from shared.messages import EndEffector, FtSample
from shared.service import Inputs, Output
from shared.spatial import GRAVITY, quaternion, quaternion_from_rpy, rotation_matrix
from shared.topics import (
    COMMAND_BASE_TWIST,
    SENSOR_FT,
    STATE_BASE,
    STATE_EE,
    STATE_GRIPPER,
    STATE_JOINTS,
    STATE_ROBOT,
    Topic,
)

Change = Callable[[Output], Iterable[Output]]


class WrongRobot(MockRobot):
    """A mock robot whose messages are changed on their way out, and its inputs on their way in."""

    def __init__(self, outwards: Change | None = None, inwards: Callable[[Inputs], None] | None = None) -> None:
        super().__init__(MockParameters())
        self._outwards, self._inwards = outwards or (lambda output: (output,)), inwards

    def step(self, inputs: Inputs, dt: float) -> list[Output]:
        if self._inwards is not None:
            self._inwards(inputs)
        return [told for output in super().step(inputs, dt) for told in self._outwards(output)]


class Rig:
    """A robot on the bench."""

    def __init__(self, robot: MockRobot) -> None:
        self.stack = Stack(latency=0.001)
        self.robot = robot
        self.stack.add(robot)
        self.bench = Bench(self.stack.bus, self.stack.scheduler.clock, self.stack.run)

    def listened(self) -> list[Row]:
        missing = list(listening.missing(self.bench))
        self.bench.wait(listening.LISTENED)
        return [*missing, *listening.publications(self.bench.robot), *listening.contents(self.bench.robot)]

    def moved(self) -> list[Row]:
        self.bench.wait(0.5)
        return list(moving.tool_moves(self.bench, self.bench.commander()))

    def driven(self) -> list[Row]:
        self.bench.wait(0.5)
        return list(moving.base_moves(self.bench, self.bench.commander(COMMAND_BASE_TWIST)))

    def gates(self) -> list[Row]:
        self.bench.wait(0.5)
        return list(Gates(self.bench, self.bench.commander(), self.bench.commander()).rows())

    def weighed(self, force: tuple[float, float, float], turned: float = 0.0) -> Row:
        self.bench.wait(1.5)
        before = weighing.wrench_in_base(self.bench.robot)
        about_y = rotation_matrix(quaternion_from_rpy(0.0, turned, 0.0))
        self.robot.sensors.wrench = np.concatenate((about_y @ force, np.zeros(3)))
        return weighing.weighed(self.bench, before, 1.0, patience=3.0)


def wrong(rows: Iterable[Row]) -> dict[str, str]:
    return {row.what: row.said for row in rows if not row.good}


def test_a_robot_that_keeps_the_contract_passes() -> None:
    rig = Rig(MockRobot(MockParameters()))
    rows = [*rig.listened(), rig.weighed((0.0, 0.0, -GRAVITY)), *rig.moved(), *rig.gates(), *rig.driven()]
    assert wrong(rows) == {}
    assert len(rows) == 6 + 4 + 1 + 6 + 8 + 2


def only(topic: Topic, change: Callable[[Any], Any]) -> Change:
    """A change of the messages of one topic."""

    def outwards(output: Output) -> Iterator[Output]:
        yield replace(output, message=change(output.message)) if output.topic is topic else output

    return outwards


def without(topic: Topic) -> Change:
    return lambda output: () if output.topic is topic else (output,)


def seldom(topic: Topic, every: int) -> Change:
    count = iter(range(10**9))
    return lambda output: () if output.topic is topic and next(count) % every else (output,)


def garbled(topic: Topic) -> Change:
    return lambda output: (replace(output, payload=b"\xc1") if output.topic is topic else output,)


_STUCK = FtSample(np.ones(3), np.ones(3), np.array((0, 0, 0, 1.0)), np.array((0.2, 0, 0)), False)
_names = iter(range(10**9))


@pytest.mark.parametrize(
    ("change", "what", "said"),
    [
        *((without(topic), topic.key, "missing") for topic in listening.ALWAYS),
        (garbled(STATE_JOINTS), "state/joints", "cannot be read"),
        (seldom(SENSOR_FT, 5), "sensor/ft", "20 Hz, wanted 30 to 1000 Hz"),
        (seldom(STATE_BASE, 3), "state/base", "wanted 50 to 50 Hz"),
        (lambda output: (replace(output, valid=output.topic is not STATE_EE),), "state/ee", "valid is false"),
        (only(STATE_GRIPPER, lambda told: told.replaced(opening=45.0)), "gripper", "opening 45 m: between the fingers"),
        (only(SENSOR_FT, lambda sample: _STUCK), "sensor", "axis 0, 1, 2, 3, 4, 5 of 0 to 5 gives one value"),
        (only(SENSOR_FT, lambda sample: sample.replaced(saturated=True)), "sensor", "saturated"),
        (
            only(SENSOR_FT, lambda sample: sample.replaced(tool_offset=np.array((0.2, 0, 0.01 * sample.force[0])))),
            "sensor",
            "tool_offset changes",
        ),
        (
            only(STATE_JOINTS, lambda state: state.replaced(name=state.name[:: (-1) ** next(_names)])),
            "joints",
            "changes from message to message",
        ),
        (only(STATE_ROBOT, lambda status: status.replaced(max_linear=9.0)), "state", "max_linear 9 m/s"),
        (only(STATE_ROBOT, lambda status: status.replaced(base_type="omni")), "state", "they contradict"),
        (only(STATE_ROBOT, lambda status: status.replaced(reason="")), "state", "without a reason"),
    ],
)
def test_what_is_told_wrongly_is_named(change: Change, what: str, said: str) -> None:
    found = wrong(Rig(WrongRobot(change)).listened())
    assert what in found and said in found[what], found


def test_a_missing_key_is_named_within_a_second() -> None:
    rig = Rig(WrongRobot(without(STATE_GRIPPER)))
    (row,) = listening.missing(rig.bench)
    assert row.what == "state/gripper" and rig.stack.now < 1.1


def test_two_robots_are_named() -> None:
    rig = Rig(MockRobot(MockParameters()))
    rig.stack.add(MockRobot(MockParameters()))
    assert "2 sessions publish it" in wrong(rig.listened())["state/ee"]


@pytest.mark.parametrize(
    ("force", "turned", "said"),
    [
        ((0.0, 0.0, GRAVITY), 0.0, "the sign is wrong"),
        ((0.0, 0.0, 0.0), 0.0, "does not see it"),
        ((0.0, 0.0, -2.5 * GRAVITY), 0.0, "the size is wrong"),
        ((0.0, 0.0, -GRAVITY), math.radians(45.0), "45 degrees away from down"),
    ],
)
def test_a_sensor_that_weighs_wrongly_is_named(force: tuple, turned: float, said: str) -> None:
    row = Rig(MockRobot(MockParameters())).weighed(force, turned)
    assert not row.good and said in row.said


def test_a_wrong_offset_of_the_tool_is_named() -> None:
    far = only(SENSOR_FT, lambda sample: sample.replaced(tool_offset=np.array((0.3, 0.0, 0.0))))
    row = Rig(WrongRobot(far)).weighed((0.0, 0.0, -GRAVITY))
    assert not row.good and "tool_offset is wrong" in row.said


def mirrored(tool: EndEffector) -> EndEffector:
    return tool.replaced(position=tool.position * (-1, 1, 1), linear=tool.linear * (-1, 1, 1))


def beside(tool: EndEffector) -> EndEffector:
    """Of another point, 10 cm in front of the tool's origin."""
    return tool.replaced(position=tool.position + 0.1 * rotation_matrix(tool.orientation)[:, 0])


@pytest.mark.parametrize(
    ("change", "what", "said"),
    [
        (only(STATE_EE, mirrored), "tool along x", "axes or signs"),
        (
            only(STATE_EE, lambda tool: tool.replaced(position=tool.position[[1, 0, 2]])),
            "tool along y",
            "axes or signs",
        ),
        (only(STATE_EE, beside), "tool about z", "is the tool frame right?"),
        (only(STATE_EE, lambda tool: tool.replaced(linear=3.0 * tool.linear)), "tool along x", "state/ee told linear"),
        (
            only(SENSOR_FT, lambda sample: sample.replaced(orientation=quaternion(np.eye(3)))),
            "tool about x",
            "sensor/ft orientation",
        ),
    ],
)
def test_a_frame_that_is_wrong_is_named(change: Change, what: str, said: str) -> None:
    found = wrong(Rig(WrongRobot(change)).moved())
    assert what in found and said in found[what], found


def test_a_tool_that_does_not_move_is_named_with_what_the_robot_says() -> None:
    rig = Rig(MockRobot(MockParameters(still=True)))
    assert all("did not move" in said for said in wrong(rig.moved()).values())


def test_a_base_whose_odometry_is_mirrored_is_named() -> None:
    change = only(STATE_BASE, lambda base: base.replaced(position=-base.position))
    found = wrong(Rig(WrongRobot(change)).driven())
    assert "axes or signs" in found["base along x"] and "base turns" not in found
