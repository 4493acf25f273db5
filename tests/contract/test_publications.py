"""What a robot process publishes: keys, form, headers and rates."""

from __future__ import annotations

import itertools
from collections import Counter

import pytest

from shared.messages import RobotStatus
from shared.topics import (
    SENSOR_FT,
    SIM_WORLD,
    STATE_BASE,
    STATE_EE,
    STATE_GRIPPER,
    STATE_JOINTS,
    STATE_ROBOT,
    Topic,
)
from tests.contract.robot import PATIENCE, Heard, Robot
from tests.support.wait import eventually

pytestmark = pytest.mark.processes

ALWAYS = (SENSOR_FT, STATE_JOINTS, STATE_EE, STATE_BASE, STATE_GRIPPER, STATE_ROBOT)
topics = pytest.mark.parametrize("topic", ALWAYS, ids=lambda topic: topic.key)


def messages(robot: Robot, topic: Topic, count: int = 20) -> list[Heard]:
    eventually(lambda: len(robot.all(topic)) >= count, PATIENCE, f"{count} messages on {topic.key}")
    return robot.all(topic)


def rate(heard: list[Heard]) -> float:
    """Of the publisher [Hz], by its own account: what the network lost counts too."""
    first, last = heard[0].header, heard[-1].header
    return (last.seq - first.seq) / max((last.stamp - first.stamp) * 1e-9, 1e-9)


def test_every_key_of_the_robot_and_none_of_anybody_else(robot: Robot) -> None:
    for topic in ALWAYS:
        messages(robot, topic, 5)
    others = {key for key in robot.heard if not key.startswith("health/")} - {topic.key for topic in ALWAYS}
    assert others == ({SIM_WORLD.key} if robot.status.simulated else set())


def test_every_message_is_one_of_the_contract(robot: Robot) -> None:
    messages(robot, SENSOR_FT, 100)
    assert robot.rejected == []
    assert {heard.encoding for all_heard in robot.heard.values() for heard in list(all_heard)} == {
        "application/msgpack"
    }


@topics
def test_headers_count_and_tell_the_time(robot: Robot, topic: Topic) -> None:
    heard = messages(robot, topic)
    assert len({item.header.session for item in heard}) == 1
    assert all(item.header.valid for item in heard)
    pairs = list(itertools.pairwise(item.header for item in heard))
    assert all(after.seq > before.seq and after.stamp > before.stamp for before, after in pairs)
    steps = Counter(after.seq - before.seq for before, after in pairs)
    assert steps.most_common(1)[0][0] == 1


@topics
def test_rates(robot: Robot, topic: Topic) -> None:
    slowest, fastest = {
        SENSOR_FT: (30.0, 1000.0),
        STATE_JOINTS: (50.0, 1000.0),
        STATE_EE: (50.0, 1000.0),
    }.get(topic, (topic.rate, topic.rate))
    # On a busy machine not every second is as it should be, but some are.
    wanted = max(10, round(slowest))

    def as_it_should_be() -> bool:
        recent = robot.all(topic)[-wanted:]
        return len(recent) == wanted and 0.8 * slowest <= rate(recent) <= 1.2 * fastest

    eventually(as_it_should_be, PATIENCE, f"{topic.key} at {slowest:g} to {fastest:g} Hz")


def test_joints_are_named_once_and_complete(robot: Robot) -> None:
    heard = messages(robot, STATE_JOINTS)
    names = {item.message.name for item in heard}
    assert len(names) == 1
    (joints,) = names
    assert len(set(joints)) == len(joints) > 0


def test_the_status_says_what_the_robot_can_do(robot: Robot) -> None:
    status: RobotStatus = messages(robot, STATE_ROBOT, 1)[-1].message
    assert 0.0 < status.max_linear <= 2.0 and 0.0 < status.max_angular <= 6.0
    assert status.mode == "holding" and status.reason != ""
