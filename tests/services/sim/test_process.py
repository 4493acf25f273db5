"""The simulator as users start it: a process behind a real router."""

from __future__ import annotations

import signal
from collections.abc import Iterator

import pytest

from shared import topics
from shared.messages import TwistCommand
from shared.parameters import Refused
from shared.wire.client import Client
from shared.wire.zenoh import ZenohBus
from tests.conftest import Router, StartProcess
from tests.support.processes import Process
from tests.support.wait import eventually

pytestmark = pytest.mark.processes


@pytest.fixture
def client(router: Router) -> Iterator[Client]:
    bus = ZenohBus(connect=router.endpoint)
    yield Client(bus)
    bus.close()


@pytest.fixture
def simulator(start: StartProcess, router: Router, client: Client) -> Process:
    process = start("services.sim", "--connect", router.endpoint)
    eventually(lambda: "sim" in client.bus.living(), 20.0, "the simulator is alive")
    return process


def test_every_topic_arrives_and_a_command_moves_the_tool(client: Client, simulator: Process) -> None:
    published = (
        topics.SENSOR_FT,
        topics.STATE_JOINTS,
        topics.STATE_EE,
        topics.STATE_BASE,
        topics.STATE_GRIPPER,
        topics.STATE_ROBOT,
        topics.SIM_WORLD,
        topics.health_topic("sim"),
    )
    subscriptions = {topic.key: client.watch(topic) for topic in published}
    eventually(
        lambda: all(subscription.accepted >= 3 for subscription in subscriptions.values()),
        20.0,
        "every topic three times",
    )
    assert all(subscription.rejected == 0 for subscription in subscriptions.values())
    tool = subscriptions["state/ee"]
    start = tool.latest.message.position[2]
    assert start == pytest.approx(1.0, abs=1e-3)

    def lowered() -> bool:
        client.publish(topics.COMMAND_EE_TWIST, TwistCommand((0, 0, -0.1), (0, 0, 0), 0.05))
        return bool(tool.latest.message.position[2] < start - 0.03)

    eventually(lowered, 20.0, "the tool goes down")
    eventually(lambda: abs(tool.latest.message.linear[2]) < 1e-3, 10.0, "the tool stands still")


def test_a_bag_hangs_and_nonsense_is_refused(client: Client, simulator: Process) -> None:
    world = client.watch(topics.SIM_WORLD)
    assert client.ask(topics.SIM_COMMAND, {"command": "load", "mass": 2.0}) == {"ok": True}
    eventually(lambda: world.latest and world.latest.message.bag, 10.0, "a bag in sim/world")
    assert world.latest is not None
    assert world.latest.message.bag.mass == 2.0
    with pytest.raises(Refused, match="allowed are reset, load, push"):
        client.ask(topics.SIM_COMMAND, {"command": "dance"})
    assert simulator.running


def test_it_ends_on_sigterm_with_status_0(simulator: Process) -> None:
    simulator.signal(signal.SIGTERM)
    assert simulator.wait(5.0) == 0


def test_images_are_rendered_elsewhere_and_only_for_those_who_look(
    client: Client, router: Router, start: StartProcess
) -> None:
    process = start("services.sim", "--connect", router.endpoint, "--set", 'scene="carry"')
    eventually(lambda: "sim" in client.bus.living(), 20.0, "the simulator is alive")
    assert not client.bus.wanted(topics.SENSOR_CAMERA.key)
    camera, ft = client.watch(topics.SENSOR_CAMERA), client.watch(topics.SENSOR_FT)
    eventually(lambda: camera.accepted >= 10, 30.0, "ten images")
    assert camera.rejected == 0 and camera.latest is not None
    assert len(camera.latest.message.data) > 5000
    assert ft.accepted > 3 * camera.accepted
    process.signal(signal.SIGTERM)
    assert process.wait(5.0) == 0


@pytest.mark.parametrize(
    ("setting", "says"),
    [
        ("ft_rate=3", "ft_rate is 3"),
        ("seed=-1", "seed is -1"),
        ('base_type="tracked"', "base_type"),
        ("ft_noise=[1, 2]", "ft_noise"),
        ("colour=1", "colour is no parameter"),
    ],
)
def test_a_bad_setting_ends_it_with_status_2_and_one_line(
    start: StartProcess, setting: str, says: str
) -> None:
    process = start("services.sim", "--set", setting)
    assert process.wait(20.0) == 2
    complaints = [line for line in process.output.splitlines() if line.startswith("sim:")]
    assert len(complaints) == 1
    assert says in complaints[0]
