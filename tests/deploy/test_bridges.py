"""A robot of ROS that is reached by a bridge in a container, on the closed network: the profiles ros1 and ros2.

The robot is the simulated one, as a process of this machine. Skipped by name where there are no containers; with
TANDEM_CONTAINERS=required, as in .ci/run, it fails instead.
"""

from __future__ import annotations

import functools
import os
import socket
from collections.abc import Iterator

import numpy as np
import pytest

from shared.spatial import rotation_matrix, rpy_from_rotation
from tests.conftest import _processes, _router
from tests.support import compose, ros1, ros2
from tests.support.compose import Compose
from tests.support.wait import eventually as _eventually

pytestmark = [pytest.mark.processes, pytest.mark.slow, pytest.mark.timeout(1500)]

PATIENCE = 120.0  # [s]
MOVED, RESTS = 0.05, 0.002
"""[m] by which the tool has gone, and by which a tool at rest may seem to."""
eventually = functools.partial(_eventually, every=1.0)


def _address() -> str:
    """An address of this machine that containers reach, too: the one it would itself dial others from."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.connect(("192.0.2.1", 9))  # sends nothing
        return str(probe.getsockname()[0])


@pytest.fixture(scope="module", params=["ros1", "ros2"])
def stack(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Compose]:
    compose.wanted()
    profile, here = request.param, _address()
    with _processes(tmp_path_factory.mktemp(profile)) as start:
        robot = (ros1 if profile == "ros1" else ros2).robot(start, _router(start).endpoint, host=here, rate=ros1.USUAL)
        dialect = "" if profile == "ros1" else " --set dialect=rmw_zenoh"
        settings = {
            **robot,
            "COMPOSE_PROFILES": profile,
            "TANDEM_CONFIG": "",
            "TANDEM_BRIDGE": f"--set profile=tiago-{profile} --set require_enable=false{dialect}",
        }
        with Compose(f"tandem-test-{profile}-{os.getpid()}", settings=settings) as stack:
            stack.do("up", "-d")
            yield stack


@pytest.fixture(scope="module")
def bridge(stack: Compose) -> str:
    """Name of the bridge's service."""
    return "bridge_" + stack.settings["COMPOSE_PROFILES"]


def place(stack: Compose) -> np.ndarray:
    """Where the robot says its tool is [m]."""
    return np.array(stack.newest("state/ee")[0]["position"])


def test_it_comes_to_rest_as_it_starts_and_moves_when_it_was_released(stack: Compose, bridge: str) -> None:
    def there() -> bool:
        return "robot" in stack.tandem("status").stdout and bool(stack.newest("state/ee"))

    eventually(there, PATIENCE, lambda: stack.tandem("status").stdout + stack.log(bridge))
    assert stack.newest("state/robot")[0]["mode"] == "stopped"
    at = stack.newest("state/ee")[0]
    x, y, z = at["position"]
    attitude = rpy_from_rotation(rotation_matrix(at["orientation"]))
    eventually(lambda: stack.tandem("tare").returncode == 0, PATIENCE, "a zero")
    goal = [f"{value:.4f}" for value in (x, y, z - 2.0 * MOVED, *attitude)]
    assert stack.run("run", "-d", "--rm", "tandem", "hold", "--", *goal).returncode == 0
    assert np.linalg.norm(place(stack) - (x, y, z)) < RESTS, "nobody has released it"

    def lower() -> bool:
        stack.tandem("resume")
        return bool(place(stack)[2] < z - MOVED)

    eventually(lower, PATIENCE, lambda: stack.tandem("status").stdout)


def test_one_that_is_killed_leaves_the_robot_at_rest_until_somebody_releases_it(stack: Compose, bridge: str) -> None:
    stack.do("kill", bridge)
    stack.do("start", bridge)
    eventually(lambda: bool(stack.newest("state/robot")), PATIENCE, lambda: stack.log(bridge))
    before = place(stack)
    said = stack.newest("state/robot", 20)
    assert {each["mode"] for each in said} == {"stopped"} and "just started" in said[0]["reason"]
    assert np.linalg.norm(place(stack) - before) < RESTS
    assert stack.tandem("resume").returncode == 0


def test_it_ends_by_itself_within_two_seconds(stack: Compose, bridge: str) -> None:
    stack.do("stop", bridge)
    assert stack.inspect(bridge, "State", "ExitCode") == 0
