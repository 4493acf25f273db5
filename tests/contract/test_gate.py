"""The gates of a robot process, from outside: whatever is commanded of tool and base, by whomever.

The rules are the same for both, but a base brakes in its time.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import msgpack
import numpy as np
import pytest

from shared.messages import BaseTwistCommand, RobotStatus, TwistCommand
from shared.schema.records import Record
from shared.spatial import Array
from shared.topics import COMMAND_BASE_TWIST, COMMAND_EE_TWIST, STATE_BASE, STATE_EE, Topic
from tests.contract.robot import PATIENCE, ZERO, Commander, Robot
from tests.support.wait import eventually, throughout

pytestmark = pytest.mark.processes

Velocity = tuple[float, float, float]


@dataclass(frozen=True)
class Part:
    """What a command moves: along two of its axes, and back after so many commands, so that it stays near."""

    topic: Topic
    state: Topic
    command: Callable[[Any, float], Record]
    one: Velocity
    other: Velocity
    turns: int
    velocity: Callable[[Any], Array]
    at_rest: Callable[[Robot], Callable[[], bool]]
    fastest: Callable[[RobotStatus], float]

    def swaying(self, velocity: Velocity, ttl: float = 0.1) -> Callable[[], Record]:
        """Commands of a velocity back and forth."""
        count = iter(range(10**9))
        return lambda: self.command(
            np.array(velocity) * (1 if (next(count) + self.turns // 2) // self.turns % 2 else -1), ttl
        )

    def moves(self, robot: Robot, along: Velocity) -> Callable[[], bool]:
        axis = int(np.argmax(along))
        return lambda: abs(self.velocity(self.now(robot))[axis]) > 0.4 * along[axis]

    def now(self, robot: Robot) -> Any:
        return robot.heard[self.state.key][-1].message

    def rests(self, robot: Robot) -> None:
        eventually(self.at_rest(robot), PATIENCE, "it stands still")


TOOL = Part(
    topic=COMMAND_EE_TWIST,
    state=STATE_EE,
    command=lambda velocity, ttl: TwistCommand(velocity, ZERO, ttl),
    one=(0.0, 0.0, 0.05),
    other=(0.0, 0.05, 0.0),
    turns=50,
    velocity=lambda tool: tool.linear,
    at_rest=lambda robot: robot.at_rest,
    fastest=lambda status: 1.1 * status.max_linear,
)
BASE = Part(
    topic=COMMAND_BASE_TWIST,
    state=STATE_BASE,
    command=BaseTwistCommand,
    one=(0.0, 0.0, 0.2),
    other=(0.1, 0.0, 0.0),
    turns=100,
    velocity=lambda base: base.velocity,
    at_rest=lambda robot: robot.base_at_rest,
    fastest=lambda status: 1.05 * status.max_base[2],
)
both = pytest.mark.parametrize("part", [TOOL, BASE], ids=["tool", "base"])
tool = pytest.mark.parametrize("part", [TOOL], ids=["tool"])


@pytest.fixture
def topic(part: Part) -> Topic:
    """Of the commanders."""
    return part.topic


@both
def test_silence_means_stop(robot: Robot, commander: Commander, part: Part) -> None:
    expired = robot.counted("expired")
    commander.make = part.swaying(part.one)
    eventually(part.moves(robot, part.one), PATIENCE, "it moves")
    eventually(lambda: part is BASE or robot.status.mode == "ready", PATIENCE, "the robot says so")
    commander.make = lambda: None
    part.rests(robot)
    eventually(lambda: robot.status.mode == "holding", PATIENCE, "the gate holds")
    eventually(lambda: robot.counted("expired") == expired + 1, PATIENCE, "it is counted once")
    where = part.now(robot).position
    throughout(lambda: np.linalg.norm(part.now(robot).position - where) < 1e-3, 0.5, "it stays")
    throughout(part.at_rest(robot), 0.1, "and stands still")


@pytest.mark.parametrize(
    ("part", "velocity", "ttl", "acts"),
    [
        (TOOL, TOOL.one, 0.02, 0.02),
        (TOOL, TOOL.one, 0.1, 0.1),
        (TOOL, TOOL.one, 100.0, 0.2),
        # A base that rolls slowly has come to rest within a second.
        (BASE, BASE.other, 100.0, 0.9),
    ],
    ids=["20 ms", "100 ms", "100 s", "base"],
)
def test_a_command_acts_for_its_ttl_and_no_longer(
    robot: Robot, commander: Commander, part: Part, velocity: Velocity, ttl: float, acts: float
) -> None:
    allowed = max(velocity) * acts
    signs = itertools.cycle((-1.0, 1.0))

    def moved_by_one_command() -> bool:
        part.rests(robot)
        start = part.now(robot).position
        command = part.command(next(signs) * np.array(velocity), ttl)
        commander.put(part.topic.key, commander.payload(command))

        def distance() -> float:
            return float(np.linalg.norm(part.now(robot).position - start))

        throughout(lambda: distance() < 1.1 * allowed + 3e-4, 3.0 * acts + 0.5, "it goes no further")
        assert part.at_rest(robot)()
        return distance() > (0.3 * allowed if part is TOOL else 1e-3)

    # On a busy machine a command may come too late to act for so long, or at all; not every one does.
    eventually(moved_by_one_command, PATIENCE, "one command moves it")


@tool
def test_commands_slower_than_their_ttl_flood_nobody(robot: Robot, commander: Commander, part: Part) -> None:
    turn = iter(range(10**9))
    command = part.swaying(part.one, ttl=0.02)
    expired = robot.counted("expired")
    commander.make = lambda: command() if next(turn) % 3 == 0 else None
    eventually(part.moves(robot, part.one), PATIENCE, "the tool moves")
    before = robot.heard["state/robot"][-1].header
    eventually(lambda: robot.heard["state/robot"][-1].header.seq >= before.seq + 8, PATIENCE, "eight reports")
    after = robot.heard["state/robot"][-1].header
    assert (after.seq - before.seq) / ((after.stamp - before.stamp) * 1e-9) < 12.0
    assert robot.counted("expired") <= expired + 2


@both
def test_of_two_publishers_the_second_is_refused_and_named(
    robot: Robot, commander: Commander, second: Commander, part: Part
) -> None:
    refused = robot.counted("second session")
    commander.make = part.swaying(part.one)
    eventually(part.moves(robot, part.one), PATIENCE, "the first one moves it")
    second.make = part.swaying(part.other)

    # What is left of an earlier test's second one, on the other topic, may be counted still.
    def named() -> bool:
        return robot.counted("second session") > refused and part.topic.key in robot.status.reason

    eventually(named, PATIENCE, lambda: f"the second one is named: {robot.status.reason}")
    commander.make = lambda: None
    eventually(part.moves(robot, part.other), PATIENCE, "the second one, once the first is silent")


@tool
def test_what_is_out_of_sequence_is_not_executed_and_named(robot: Robot, commander: Commander, part: Part) -> None:
    robot.rests()
    refused = robot.counted("out of sequence")
    turn = iter(range(10**9))
    commander.number = 1000

    def make() -> TwistCommand | bytes:
        if next(turn) % 2:
            return TwistCommand(ZERO, ZERO, 0.1)
        return commander.payload(TwistCommand((0, 0, -0.05), ZERO, 0.2), number=10)

    # The first one sets the sequence; what is behind it is old.
    commander.put(part.topic.key, commander.payload(TwistCommand(ZERO, ZERO, 0.1)))
    commander.make = make
    start = robot.tool.position
    eventually(lambda: robot.counted("out of sequence") >= refused + 5, PATIENCE, "it is counted")
    assert np.linalg.norm(robot.tool.position - start) < 1e-3


HEADER = {"seq": 1, "session": 1, "stamp": 1, "valid": True}
TWIST = {"linear": [0.05, 0.0, 0.0], "angular": [0.0] * 3, "ttl": 0.1}
GARBAGE = b"\xc1" * 50
NO_COMMANDS = {
    "nothing": b"",
    "garbage": GARBAGE,
    "a megabyte": bytes(1_000_000),
    "no header": msgpack.packb(TWIST),
    "NaN": msgpack.packb(HEADER | TWIST | {"linear": [math.nan, 0.0, 0.0]}),
    "infinite": msgpack.packb(HEADER | TWIST | {"angular": [0.0, math.inf, 0.0]}),
    "shape": msgpack.packb(HEADER | TWIST | {"linear": [0.05, 0.0]}),
    "type": msgpack.packb(HEADER | TWIST | {"ttl": "long"}),
    "field missing": msgpack.packb(HEADER | {"angular": [0.0] * 3, "ttl": 0.1}),
}


@pytest.mark.parametrize(
    ("part", "command"),
    [(TOOL, command) for command in NO_COMMANDS.values()] + [(BASE, GARBAGE)],
    ids=[*NO_COMMANDS, "garbage for the base"],
)
def test_what_is_no_command_moves_nothing_and_is_counted(
    robot: Robot, commander: Commander, part: Part, command: bytes
) -> None:
    part.rests(robot)
    start = part.now(robot).position
    rejected = robot.counted("rejected")
    commander.make = lambda: command
    eventually(lambda: robot.counted("rejected") >= rejected + 5, PATIENCE, "it is counted")
    assert np.linalg.norm(part.now(robot).position - start) < 1e-3


@tool
def test_an_unknown_field_is_ignored(robot: Robot, commander: Commander, part: Part) -> None:
    command = part.swaying(part.one)
    commander.make = lambda: msgpack.packb(msgpack.unpackb(commander.payload(command())) | {"colour": "red"})
    eventually(part.moves(robot, part.one), PATIENCE, "the tool moves")


@both
def test_a_command_that_is_marked_invalid_means_stop(robot: Robot, commander: Commander, part: Part) -> None:
    command = part.swaying(part.one)
    commander.make = command
    eventually(part.moves(robot, part.one), PATIENCE, "it moves")
    commander.make = lambda: commander.payload(command(), valid=False)
    part.rests(robot)
    throughout(part.at_rest(robot), 0.5, "it stands still")


@both
def test_an_excess_is_clamped_and_told(robot: Robot, commander: Commander, part: Part) -> None:
    told = "base commands clamped" if part is BASE else "clamped"
    clamped = robot.counted(told)
    commander.make = part.swaying(1e6 * np.sign(part.one), ttl=1e6)
    eventually(lambda: robot.counted(told) > clamped, PATIENCE, "the excess is told")
    eventually(part.moves(robot, part.one), PATIENCE, "it moves all the same")
    robot.heard[part.state.key].clear()
    eventually(lambda: len(robot.all(part.state)) > part.turns, PATIENCE, "a while of it")
    fastest = max(np.linalg.norm(part.velocity(heard.message)) for heard in robot.all(part.state))
    assert 0.4 * max(part.one) < fastest <= part.fastest(robot.status)


@pytest.mark.parametrize("part", [BASE], ids=["base"])
def test_only_an_omnidirectional_base_goes_sideways(robot: Robot, commander: Commander, part: Part) -> None:
    omni = robot.status.base_type == "omni"
    assert (robot.status.max_base[1] > 0.0) == omni
    clamped = robot.counted("base commands clamped")
    start, sideways = robot.base.position, (0.0, 0.1, 0.0)
    commander.make = part.swaying(sideways)
    if omni:
        eventually(part.moves(robot, sideways), PATIENCE, "it goes sideways")
        return
    eventually(lambda: robot.counted("base commands clamped") > clamped, PATIENCE, "it is told")
    throughout(lambda: np.linalg.norm(robot.base.position - start) < 2e-3, 0.5, "it stays")


@pytest.mark.parametrize(
    ("part", "valid"), [(TOOL, True), (TOOL, False), (BASE, True)], ids=["tool", "tool, invalid", "base"]
)
def test_a_stop_is_latched_whoever_comes_and_goes_and_only_a_valid_release_ends_it(
    robot: Robot, commander: Commander, second: Commander, part: Part, valid: bool
) -> None:
    moves = part.moves(robot, part.one)
    commander.make = part.swaying(part.one)
    eventually(moves, PATIENCE, "it moves")
    second.stop(True, "hand on the button", valid)
    try:
        eventually(lambda: robot.status.mode == "stopped", PATIENCE, "the gate is stopped")
        assert "hand on the button" in robot.status.reason
        part.rests(robot)
        commander.make = lambda: None
        second.make = part.swaying(part.one)
        throughout(part.at_rest(robot), 0.5, "another one who commands does not move it either")
        second.stop(False, valid=False)
        throughout(part.at_rest(robot), 0.3, "nor after an invalid release")
        assert robot.status.mode == "stopped"
    finally:
        second.stop(False)
    eventually(moves, PATIENCE, "it moves after the release")
