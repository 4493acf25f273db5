"""The way between a bridge and its robot is cut, and that to the bus is not: the robot comes to rest by itself.

The bridge is on another machine, at the end of a cable. Skipped by name where there is no second machine; with
TANDEM_MACHINES=required, as in .ci/run, it fails instead.

Times are those of the robot's world, which tells one sample in each 20 ms of its own: on a busy machine it goes slower
than the clock of its stamps.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import pytest

from shared.topics import STATE_JOINTS
from tests.conftest import StartProcess
from tests.faults import test_bridge_ros1, test_bridge_ros2, test_bridge_ros2dds
from tests.faults.test_bridge_ros2 import ARM_WITHIN, BASE_WITHIN, SAMPLE, last_motion
from tests.support import far_machine, ros1
from tests.support.elsewhere import Elsewhere
from tests.support.far_machine import FarMachine
from tests.support.ports import free_port
from tests.support.ros1 import RosNode
from tests.support.wait import eventually

pytestmark = [pytest.mark.processes, pytest.mark.slow, pytest.mark.timeout(300)]
MENDED = 0.5, 2.0
"""[s] after which the cable is whole again: while TCP would still deliver what it could not, and after that."""
TOLD = 2.0  # [s] for which the robot is looked at afterwards
Speeds = Callable[[], list[float]]


@pytest.fixture
def far() -> Iterator[FarMachine]:
    if why := far_machine.unusable():
        (pytest.fail if os.environ.get("TANDEM_MACHINES") == "required" else pytest.skip)(why)
    with FarMachine() as far:
        yield far


@pytest.fixture
def port(far: FarMachine, start: StartProcess) -> int:
    """Of the bus, which both machines reach."""
    port = free_port()
    start("services.router", "--listen", f"tcp/{far.here}:{port}").wait_for_output(str(port))
    return port


def cut(far: FarMachine, port: int, mended: float, arm: Speeds, base: Speeds) -> None:
    """Cut the cable for a time [s]: arm and base come to rest in time, and nothing moves once it is whole again."""
    far.cut(but=port)
    begun = len(arm()), len(base())
    eventually(lambda: len(arm()) > begun[0] + mended / SAMPLE, 60.0, "the robot tells on")
    far.mend()
    enough = (mended + TOLD) / SAMPLE
    eventually(lambda: min(len(arm()) - begun[0], len(base()) - begun[1]) > enough, 120.0, "the robot tells on")
    took = [last_motion(speeds()[count:]) for speeds, count in zip((arm, base), begun, strict=True)]
    print(f"cut off for {mended:g} s: arm at rest after {took[0]:.2f} s, base after {took[1]:.2f} s")
    assert took[0] < ARM_WITHIN + SAMPLE and took[1] < BASE_WITHIN + SAMPLE


def test_a_robot_of_ros_1_that_is_cut_off_rests_and_does_not_go_on_by_itself(
    far: FarMachine, port: int, start: StartProcess, monkeypatch: pytest.MonkeyPatch
) -> None:
    bus = f"tcp/{far.here}:{port}"
    found = ros1.robot(start, bus, host=far.here)
    for name, value in found.items():
        monkeypatch.setenv(name, value)
    with Elsewhere(RosNode, "watcher") as watcher:
        scene = test_bridge_ros1.Scene(start, bus, watcher, {**found, "ROS_IP": far.address}, far.within)
        arm, base = (
            lambda topic=topic: [speed for _, speed in scene.speeds(topic)]
            for topic in (test_bridge_ros1.JOINTS, test_bridge_ros1.ODOMETRY)
        )
        with scene.operator:
            for mended in MENDED:
                scene.set_off()
                cut(far, port, mended, arm, base)
                assert "stop engaged" in scene.reason
            heard = scene.operator.hear(STATE_JOINTS)
            eventually(lambda: len(heard) > 10, 30.0, lambda: scene.reason)
            scene.set_off()


@pytest.mark.parametrize("under", ["rmw_zenoh", "dds"])
def test_a_robot_of_ros_2_that_is_cut_off_rests_and_does_not_go_on_by_itself(
    far: FarMachine, port: int, start: StartProcess, tmp_path: Path, under: str
) -> None:
    make = test_bridge_ros2.Scene if under == "rmw_zenoh" else partial(test_bridge_ros2dds.DomainScene, tmp_path)
    scene = make(f"tcp/{far.here}:{port}", start, far.here, far.within)
    witness = scene.witness
    try:
        with scene.around:
            for mended in MENDED:
                scene.moves()
                cut(
                    far,
                    port,
                    mended,
                    lambda: [sample.speed for sample in witness.arm],
                    lambda: [sample.speed for sample in witness.base],
                )
                assert scene.stopped(), scene.words
            scene.moves()
    finally:
        witness.close()
