"""The far side before the real zenoh-bridge-ros2dds: what only that shows, and the simulated robot behind it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from services.bridge_ros2.parameters import BridgeRos2Parameters
from services.bridge_ros2.robot import Ros2Robot
from shared.robot.far_side import TrajectoryPoint
from shared.robot.profile import Profile
from tests.conftest import Router, StartProcess
from tests.services.bridge_ros2 import peer
from tests.services.bridge_ros2.far import FarNetwork
from tests.services.bridge_ros2.far_dds import FarDomain
from tests.support import ros2dds
from tests.support.dds import free_domain
from tests.support.ports import open_session
from tests.support.wait import eventually

pytestmark = pytest.mark.processes
PROFILE = Profile.load("tiago-ros2")
BASE, STOP, HEAD = PROFILE.base, PROFILE.emergency_stop, PROFILE.controllers["head"]
assert BASE is not None and STOP is not None
SOON = 60.0  # [s]
SPACE = "/robot1"


@pytest.fixture
def domain() -> int:
    return free_domain()


@pytest.fixture
def spaced(start: StartProcess, tmp_path: Path, domain: int) -> Iterator[FarDomain]:
    """A node behind a program with a namespace."""
    _, endpoint = ros2dds.bridge(start, tmp_path, domain, namespace=SPACE)
    with closing(FarDomain(domain, endpoint)) as far:
        yield far


def whole(far: FarDomain | FarNetwork) -> None:
    for topic, kind in PROFILE.heard().items():
        far.advertise(topic, kind, latched=topic == STOP.topic)
    for topic, kind in PROFILE.commanded().items():
        far.listen(topic, kind)


def tokens(endpoint: str) -> set[str]:
    """Of all topics, without their sessions."""
    with closing(open_session(endpoint)) as session:
        told = [reply.ok for reply in session.liveliness().get("@/*/@ros2_lv/**") if reply.ok]
        rows = [str(sample.key_expr).split("/", 3) for sample in told]
    return {row[3] for row in rows if len(row) == 4}


def test_a_namespace_stands_before_every_topic(spaced: FarDomain) -> None:
    whole(spaced)
    parameters = BridgeRos2Parameters.of({"far": spaced.endpoint, "namespace": SPACE})
    with closing(Ros2Robot(PROFILE, parameters)) as robot:
        spaced.publish(STOP.topic, peer.Bool(False).serialize())
        eventually(lambda: not robot.ready() and not robot.mismatches(), message=lambda: str(robot.mismatches()))
        eventually(lambda: robot.drive(np.zeros(3)) or spaced.received[BASE.topic], every=0.05)


def test_tokens_are_those_of_the_stand_in(
    start: StartProcess, tmp_path: Path, domain: int, shared_router: Router
) -> None:
    _, endpoint = ros2dds.bridge(start, tmp_path, domain)
    with closing(FarDomain(domain, endpoint)) as real, closing(FarNetwork(shared_router.endpoint, "ros2dds")) as other:
        whole(real)
        whole(other)
        wanted = tokens(shared_router.endpoint)
        eventually(lambda: tokens(endpoint) == wanted, message=lambda: str(tokens(endpoint) ^ wanted), every=0.1)


def test_it_hears_and_moves_the_simulated_robot(
    start: StartProcess, tmp_path: Path, domain: int, shared_router: Router
) -> None:
    _, endpoint = ros2dds.bridge(start, tmp_path, domain)
    settings = ('profile="tiago-ros2"', 'transport="dds"', f'address="{domain}"', "control_rate=100.0")
    chosen = [f"--set={setting}" for setting in settings]
    start("services.ros_robot", "--connect", shared_router.endpoint, *chosen)
    with closing(Ros2Robot(PROFILE, BridgeRos2Parameters.of({"far": endpoint}))) as robot:
        eventually(lambda: not robot.ready() and not robot.mismatches(), SOON, lambda: str(robot.mismatches()))
        eventually(lambda: robot.joints() and robot.wrench() and robot.odometry(), SOON)
        picture, calibration = eventually(lambda: robot.picture(True), SOON)
        assert picture.message.width == calibration.message.width > 0
        assert not robot.emergency() and not robot.refusals()
        names = robot.joints().message.names
        place = [names.index(joint) for joint in HEAD.joints]
        aim = robot.joints().message.position[place] + np.array((0.1, -0.1))
        robot.move("head", [TrajectoryPoint(0.5, aim, np.zeros(2))])
        eventually(lambda: np.allclose(robot.joints().message.position[place], aim, atol=0.005), SOON)

        def goes() -> bool:
            robot.drive(np.array((0.1, 0.0, 0.0)))
            return bool(robot.odometry().message.velocity[0] > 0.05)

        eventually(goes, SOON, every=0.05)
