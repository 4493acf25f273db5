"""What a robot process publishes: keys, form, headers and rates."""

from __future__ import annotations

import io
import itertools
from collections import Counter

import pytest
from PIL import Image

from services.cli.check.heard import ALWAYS, Heard
from services.cli.check.listening import allowed_rate, rate
from shared.messages import CameraImage, Header, RobotStatus
from shared.sim_messages import SimWorld
from shared.topics import (
    SENSOR_CAMERA,
    SENSOR_FT,
    SIM_WORLD,
    STATE_BASE,
    STATE_JOINTS,
    STATE_ROBOT,
    Topic,
)
from shared.wire.codec import decode
from tests.contract.robot import PATIENCE, Robot, RobotProcess
from tests.support.wait import eventually

pytestmark = pytest.mark.processes

topics = pytest.mark.parametrize("topic", ALWAYS, ids=lambda topic: topic.key)


def messages(robot: Robot, topic: Topic, count: int = 20) -> list[Heard]:
    eventually(lambda: len(robot.all(topic)) >= count, PATIENCE, f"{count} messages on {topic.key}")
    return robot.all(topic)


def test_every_key_of_the_robot_and_none_of_anybody_else(robot: Robot, kind: RobotProcess) -> None:
    wanted = {topic.key for topic in ALWAYS}
    wanted |= {SIM_WORLD.key} if kind.world else set()
    # Who listens to everything listens to the camera too.
    wanted |= {SENSOR_CAMERA.key} if kind.camera else set()
    with robot.listening("**") as samples:
        eventually(lambda: wanted <= set(map(robot.key, list(samples))), PATIENCE, "every key is heard")
    heard = {key for key in map(robot.key, samples) if not key.startswith(("health/", "setup/"))}
    assert heard == wanted


def test_every_message_is_one_of_the_contract(robot: Robot) -> None:
    messages(robot, SENSOR_FT, 100)
    assert robot.rejected == []
    assert {heard.encoding for all_heard in robot.heard.values() for heard in list(all_heard)} == {
        "application/msgpack"
    }


def test_the_camera_delivers_while_somebody_subscribes_and_only_then(robot: Robot, kind: RobotProcess) -> None:
    if not kind.camera:
        pytest.skip("it has no camera")

    def pictures(count: int) -> list[tuple[Header, CameraImage]]:
        with robot.listening(SENSOR_CAMERA.key) as samples:
            eventually(lambda: len(samples) >= count, PATIENCE, f"{count} pictures")
        return [decode(CameraImage, item.payload.to_bytes(), SENSOR_CAMERA.cap) for item in samples]

    before = pictures(12)
    header, image = before[-1]
    assert header.valid
    assert Image.open(io.BytesIO(image.data)).size == (image.width, image.height)
    # Whether it goes on where nobody hears it, the numbers tell that it has used up meanwhile.
    told = robot.all(STATE_BASE)[-1].header.seq
    eventually(lambda: robot.all(STATE_BASE)[-1].header.seq > told + 100, PATIENCE, "two seconds of something else")
    assert pictures(1)[0][0].seq < header.seq + 10


def test_a_simulation_has_a_panel_that_it_tells_of(robot: Robot, kind: RobotProcess) -> None:
    if not kind.world:
        pytest.skip("only a simulation tells of its world")
    for heard in messages(robot, SIM_WORLD):
        world: SimWorld = heard.message
        assert world.panel is not None and world.panel.position[2] > 0.1
        assert world.contact_force == pytest.approx((0.0, 0.0, 0.0))


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
    slowest, fastest = allowed_rate(topic)
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
