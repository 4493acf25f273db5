"""The real zenoh-bridge-ros2dds before a robot under DDS dies or hangs: the robot comes to rest by itself.

Seen in DDS, and in the robot's own time: by what it publishes, from the last sample before the loss on.
"""

from __future__ import annotations

import signal
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from cyclonedds.domain import Domain, DomainParticipant

from services.ros_robot.dds import LOOPBACK
from shared import topics as t
from tests.conftest import Router, StartProcess
from tests.faults import test_bridge_ros2 as same
from tests.faults.test_bridge_ros2 import (
    ARM_WITHIN,
    BASE_WITHIN,
    JOINTS,
    ODOMETRY,
    SAMPLE,
    SOON,
    STILL,
    Scene,
    Witness,
    last_motion,
)
from tests.support import dds, ros2dds
from tests.support.processes import Process
from tests.support.wait import eventually

pytestmark = [pytest.mark.processes, pytest.mark.slow]
LATE_ARM, LATE_BASE = 0.002, 0.002
"""[rad, m] by which what comes late may move what rests; 0.005 rad where a bridge does not brake for silence."""
OUTAGES = 0.6, 12.0
"""[s] for which it hangs: what it has kept is delivered when it goes on, and longer than Zenoh's lease, 10 s."""


class DomainWitness(Witness):
    """In the robot's domain of DDS."""

    def __init__(self, domain: int) -> None:
        super().__init__()
        self._domain = Domain(domain, LOOPBACK)
        self._participant = DomainParticipant(domain)
        self._readers = [
            dds.reader(self._participant, f"rt{topic}", kind, hear)
            for topic, kind, hear in (
                (JOINTS, "sensor_msgs/msg/JointState", self.hear_joints),
                (ODOMETRY, "nav_msgs/msg/Odometry", self.hear_odometry),
            )
        ]

    def close(self) -> None:
        self._readers.clear()


class DomainScene(Scene):
    """Its robot is under DDS, and before it stands zenoh-bridge-ros2dds."""

    dialect = "ros2dds"

    def __init__(
        self, folder: Path, bus: str, start: StartProcess, host: str = "127.0.0.1", within: tuple[str, ...] = ()
    ) -> None:
        self._folder, self._number = folder, dds.free_domain()
        super().__init__(bus, start, host, within)

    def start_between(self) -> Process:
        process, _ = ros2dds.bridge(self._start, self._folder, self._number, self.far)
        return process

    def _start_robot(self) -> tuple[Process, Witness]:
        return self._start_simulated(transport="dds", address=str(self._number)), DomainWitness(self._number)


@pytest.fixture
def scene(router: Router, start: StartProcess, tmp_path: Path) -> Iterator[Scene]:
    scene = DomainScene(tmp_path, router.endpoint, start)
    with scene.around:
        yield scene
    scene.witness.close()


def test_a_killed_bridge_of_ours(scene: Scene) -> None:
    same.test_a_killed_bridge_leaves_the_robot_at_rest_and_a_new_one_waits_for_a_person(scene)


def test_a_hung_bridge_of_ours(scene: Scene) -> None:
    same.test_a_hung_bridge_leaves_the_robot_at_rest_and_does_not_go_on_by_itself(scene)


def test_a_killed_one_leaves_the_robot_at_rest_and_a_new_one_sets_nothing_off(scene: Scene) -> None:
    same.test_without_the_robots_router_it_rests_and_does_not_go_on_by_itself(scene)


@pytest.mark.parametrize("outage", OUTAGES)
def test_a_hung_one_leaves_the_robot_at_rest_and_what_it_delivers_late_leads_nowhere(
    scene: Scene, outage: float
) -> None:
    witness = scene.witness
    scene.moves()
    arms, bases = len(witness.arm), len(witness.base)
    scene.between.signal(signal.SIGSTOP)
    eventually(scene.stopped, SOON, lambda: scene.words)
    enough = outage / SAMPLE
    eventually(
        lambda: min(len(witness.arm) - arms, len(witness.base) - bases) > enough, 5.0 * SOON, "the robot tells on"
    )
    arm, base = witness.arm[arms:], witness.base[bases:]
    arms, bases = len(witness.arm) - 1, len(witness.base) - 1
    joints = scene.around.hear(t.STATE_JOINTS)
    scene.between.signal(signal.SIGCONT)
    took = [last_motion(sample.speed for sample in samples) for samples in (arm, base)]
    # After a long outage DDS has to find it again, too.
    eventually(lambda: len(joints) > 10, 2.0 * SOON, lambda: scene.words)
    eventually(lambda: min(len(witness.arm) - arms, len(witness.base) - bases) > 1.5 / SAMPLE, SOON, "it tells on")
    assert scene.stopped(), scene.words
    arm, base = witness.arm[arms:], witness.base[bases:]
    went = [float(np.ptp([sample.place for sample in samples], axis=0).max()) for samples in (arm, base)]
    print(f"hung for {outage:g} s: arm at rest after {took[0]:.2f} s, base after {took[1]:.2f} s")
    print(f"what came late moved a joint by {went[0]:.5f} rad, the base by {went[1]:.5f} m")
    assert took[0] < ARM_WITHIN + SAMPLE and took[1] < BASE_WITHIN + SAMPLE
    assert went[0] < LATE_ARM and went[1] < LATE_BASE
    assert max(arm[-1].speed, base[-1].speed) < STILL
    scene.moves()
