"""A bridge that dies or hangs while the robot moves, with a real ROS 1 in between: the robot comes to rest by itself.

What counts is the robot's own word: its joint states and odometry, heard by a node of ROS that is not the bridge.
"""

from __future__ import annotations

import signal
from collections.abc import Iterator, Sequence

import numpy as np
import pytest

from shared.messages import BaseTwistCommand, Stop, TwistCommand
from shared.robot.profile import Profile
from shared.schema.records import Record
from shared.topics import COMMAND_BASE_TWIST, COMMAND_EE_TWIST, STATE_ROBOT, STOP, Topic
from shared.wire.subscription import Subscription
from tests.conftest import Router, StartProcess
from tests.support import ros1
from tests.support.elsewhere import Elsewhere
from tests.support.processes import Process
from tests.support.ros1 import RosNode
from tests.support.stand_in import StandIn
from tests.support.wait import eventually, throughout

pytestmark = pytest.mark.processes
ARM_RESTS, BASE_RESTS = 0.25, 0.5
"""Time [s] after the fault within which they are promised to be at rest."""
SAMPLE = 0.02  # [s] between two words of the robot, one of which may be the last before the fault
MOVES, RESTS = 0.03, 0.005  # [m/s, rad/s]
PROFILE = Profile.load("tiago-ros1")
assert PROFILE.base is not None
JOINTS, ODOMETRY = PROFILE.joints.topic, PROFILE.base.odometry


def to_and_fro(number: int) -> Iterator[tuple[Topic, Record]]:
    """Moves tool and base for as long as a test takes."""
    side = 0.15 if number % 200 < 100 else -0.15
    yield COMMAND_EE_TWIST, TwistCommand((0.0, side, 0.0), (0.0, 0.0, 0.0), 0.1)
    yield COMMAND_BASE_TWIST, BaseTwistCommand((0.15, 0.0, 0.0), 0.2)


class Scene:
    """A simulated TIAGo under ROS 1, a bridge, somebody who commands it, and a node that watches the robot.

    Args:
        start: starts a process.
        endpoint: of the router.
        watcher: a node.
        found: the environment of whoever is to find the robot.
        within: what the bridge's command begins with, such as another machine's.

    Attributes:
        operator: commands, and may release the stop.
        status: what the bridge says of the robot.
        bridge: its process.
    """

    def __init__(
        self,
        start: StartProcess,
        endpoint: str,
        watcher: Elsewhere[RosNode],
        found: dict[str, str],
        within: tuple[str, ...] = (),
    ) -> None:
        self._start, self._endpoint, self._environment, self._within = start, endpoint, found, within
        self._watcher = watcher
        watcher.subscribe(JOINTS, "sensor_msgs/JointState")
        watcher.subscribe(ODOMETRY, "nav_msgs/Odometry")
        self.operator = StandIn(endpoint, "robot", to_and_fro)
        self.status: Subscription = self.operator.client.watch(STATE_ROBOT)
        self.bridge = self.bridged()

    def bridged(self) -> Process:
        """Another bridge."""
        options = ("--connect", self._endpoint, "--set", "require_enable=false")
        return self._start("services.bridge_ros1", *options, environment=self._environment, within=self._within)

    def speeds(self, topic: str) -> list[tuple[float, float]]:
        """Stamps [s] of the robot's clock, and the largest speed at each of the arm's joints or of the base."""
        return [(message["header"]["stamp"], _speed(message)) for message in self._watcher.received(topic)]

    def now(self, topic: str) -> float:
        """The largest speed of late."""
        return max((speed for _, speed in self.speeds(topic)[-15:]), default=0.0)

    def set_off(self) -> None:
        """Release the stop until arm and base move."""

        def moves() -> bool:
            self.operator.client.publish(STOP, Stop(False))
            return self.now(JOINTS) > MOVES and self.now(ODOMETRY) > MOVES

        eventually(moves, 60.0, lambda: f"arm and base move: {self.reason}\n{self.bridge.output}", every=0.5)
        # A release may be on its way still.
        told = len(self.speeds(JOINTS))
        eventually(lambda: len(self.speeds(JOINTS)) > told + 25, 20.0, "the robot goes on telling")

    @property
    def reason(self) -> str:
        """Why the robot does not move."""
        return str(self.status.latest.message.reason) if self.status.latest else "nobody says anything"

    def rests_after(self, topic: str, fault: float) -> float:
        """Time [s] from a stamp to the last motion, once there is no more.

        Counted in samples, of which the robot's world tells one in each 20 ms of its own: on a busy machine it goes
        slower than the clock of its stamps.
        """

        def since() -> list[float]:
            return [speed for stamp, speed in self.speeds(topic) if stamp > fault]

        eventually(lambda: len(since()) * SAMPLE > 1.0, 40.0, "the robot goes on telling")
        return SAMPLE * max((number + 1 for number, speed in enumerate(since()) if speed > RESTS), default=0)

    def at_rest(self) -> bool:
        """Whether nothing moves now."""
        return max(self.now(JOINTS), self.now(ODOMETRY)) < RESTS


def _speed(message: dict) -> float:
    if "name" not in message:
        twist = message["twist"]["twist"]
        return float(np.hypot(twist["linear"]["x"], twist["linear"]["y"]))
    speeds: Sequence[float] = [
        abs(speed)
        for name, speed in zip(message["name"], message["velocity"], strict=True)
        if name in PROFILE.arm.joints
    ]
    return max(speeds)


@pytest.fixture
def scene(start: StartProcess, router: Router, monkeypatch: pytest.MonkeyPatch) -> Iterator[Scene]:
    found = dict(ros1.robot(start, router.endpoint))
    for name, value in found.items():
        monkeypatch.setenv(name, value)
    with Elsewhere(RosNode, "watcher") as watcher:
        scene = Scene(start, router.endpoint, watcher, found)
        with scene.operator:
            yield scene


def test_a_bridge_that_is_killed_leaves_arm_and_base_at_rest(scene: Scene) -> None:
    scene.set_off()
    fault = scene.speeds(JOINTS)[-1][0]
    scene.bridge.kill()
    arm, base = scene.rests_after(JOINTS, fault), scene.rests_after(ODOMETRY, fault)
    print(f"killed: arm at rest after {arm:.3f} s, base after {base:.3f} s")
    assert arm < ARM_RESTS + SAMPLE and base < BASE_RESTS + SAMPLE
    scene.bridge = scene.bridged()
    eventually(lambda: "just started" in scene.reason, 30.0, lambda: scene.reason)
    throughout(scene.at_rest, 1.0, "the next one moves nothing unasked")
    scene.set_off()


def test_a_bridge_that_hangs_leaves_arm_and_base_at_rest_and_stays_stopped_when_it_goes_on(scene: Scene) -> None:
    scene.set_off()
    fault = scene.speeds(JOINTS)[-1][0]
    scene.bridge.signal(signal.SIGSTOP)
    arm, base = scene.rests_after(JOINTS, fault), scene.rests_after(ODOMETRY, fault)
    print(f"hung: arm at rest after {arm:.3f} s, base after {base:.3f} s")
    assert arm < ARM_RESTS + SAMPLE and base < BASE_RESTS + SAMPLE
    scene.bridge.signal(signal.SIGCONT)
    eventually(lambda: "stood still" in scene.reason, 10.0, lambda: scene.reason)
    throughout(scene.at_rest, 1.0, "it moves nothing unasked")
    scene.set_off()


@pytest.mark.parametrize(("number", "noticed"), [(signal.SIGKILL, 0.06), (signal.SIGSTOP, 0.3)], ids=["killed", "hung"])
def test_a_router_that_is_lost_leaves_arm_and_base_at_rest(
    number: signal.Signals, noticed: float, scene: Scene, router: Router
) -> None:
    scene.set_off()
    fault = scene.speeds(JOINTS)[-1][0]
    router.process.signal(number)
    arm, base = scene.rests_after(JOINTS, fault), scene.rests_after(ODOMETRY, fault)
    print(f"router lost: arm at rest after {arm:.3f} s, base after {base:.3f} s")
    assert arm < noticed + ARM_RESTS + SAMPLE and base < noticed + BASE_RESTS + SAMPLE


def test_at_its_end_the_robot_is_at_rest(scene: Scene) -> None:
    scene.set_off()
    scene.bridge.ends_in_time()
    eventually(scene.at_rest, 2.0)
