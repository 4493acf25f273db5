"""The bridge to a robot under ROS 2 is killed or hangs, or its way there is cut: the robot comes to rest by itself.

Seen by the robot and in its own time: by what it publishes, from the last sample before the loss on.
"""

from __future__ import annotations

import json
import signal
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
import pytest
import zenoh
from rosbags.typesys import Stores, get_typestore

from shared import messages as m
from shared import topics as t
from tests.conftest import Router, StartProcess
from tests.support.ports import free_endpoint, free_port
from tests.support.processes import Process
from tests.support.stand_in import StandIn
from tests.support.wait import eventually, throughout

pytestmark = [pytest.mark.processes, pytest.mark.slow]
ARM_WITHIN, BASE_WITHIN = 0.25, 0.5  # [s] after which all is at rest
SAMPLE = 0.02  # [s] between two samples: the last one before the loss is so old at most
STILL, MOVING = 0.005, 0.02  # [rad/s, m/s]
SOON = 30.0
JOINTS, ODOMETRY = "/joint_states", "/mobile_base_controller/odom"
STORE = get_typestore(Stores.ROS2_HUMBLE)
DOWN = m.TwistCommand((0.0, 0.0, -0.03), (0.0, 0.0, 0.0), 0.2)
FORWARD = m.BaseTwistCommand((0.1, 0.0, 0.0), 0.2)


@dataclass
class Sample:
    """Greatest speed [rad/s, m/s], and where it is."""

    speed: float
    place: np.ndarray


class Witness:
    """What the robot publishes, as it arrives from itself and not through what stands between it and the bridge."""

    def __init__(self) -> None:
        self.arm: list[Sample] = []
        self.base: list[Sample] = []

    def hear_joints(self, payload: bytes) -> None:
        told = STORE.deserialize_cdr(payload, "sensor_msgs/msg/JointState")
        own = [name.startswith(("arm_right", "torso")) for name in told.name]
        self.arm.append(Sample(float(np.abs(told.velocity[own]).max()), told.position[own].copy()))

    def hear_odometry(self, payload: bytes) -> None:
        told = STORE.deserialize_cdr(payload, "nav_msgs/msg/Odometry")
        speed, place = told.twist.twist, told.pose.pose.position
        size = float(max(abs(speed.linear.x), abs(speed.linear.y), abs(speed.angular.z)))
        self.base.append(Sample(size, np.array((place.x, place.y))))

    def close(self) -> None:
        """Hear nothing more."""


class NodeWitness(Witness):
    """Connected to the robot's node under rmw_zenoh."""

    def __init__(self, endpoint: str) -> None:
        super().__init__()
        config = zenoh.Config()
        for name, value in (
            ("mode", "client"),
            ("connect/endpoints", [endpoint]),
            # It waits for the node.
            ("connect/timeout_ms", -1),
            ("connect/exit_on_failure", False),
            ("scouting/multicast/enabled", False),
        ):
            config.insert_json5(name, json.dumps(value))
        self._session = zenoh.open(config)
        self._subscribers = [
            self._session.declare_subscriber(f"0{topic}/*/*", lambda sample, hear=hear: hear(sample.payload.to_bytes()))
            for topic, hear in ((JOINTS, self.hear_joints), (ODOMETRY, self.hear_odometry))
        ]

    def close(self) -> None:
        self._session.close()


class Scene:
    """A robot under ROS 2, what stands before it, a bridge, and somebody who commands both arm and base without end.

    Here the robot is under rmw_zenoh, and before it stands its router.

    Args:
        bus: endpoint of the bridge's own router.
        start: starts a process.
        host: address of this machine by which the bridge reaches the robot.
        within: what the bridge's command begins with, such as another machine's.
        its: further settings of the bridge.
    """

    dialect = "rmw_zenoh"

    def __init__(
        self,
        bus: str,
        start: StartProcess,
        host: str = "127.0.0.1",
        within: tuple[str, ...] = (),
        its: tuple[str, ...] = ("--set=require_enable=false",),
    ) -> None:
        self.bus, self._start, self._within, self._its = bus, start, within, its
        self.far = f"tcp/{host}:{free_port()}"
        self.between = self.start_between()
        self.robot, self.witness = self._start_robot()
        self.bridge = self.start_bridge()
        self.releases = False
        self.around = StandIn(bus, "robot", self._plays)
        self.said = self.around.hear(t.STATE_ROBOT)

    def start_between(self) -> Process:
        """What stands between bridge and robot, at ``far``."""
        router = self._start("services.router", "--listen", self.far)
        router.wait_for_output(self.far)
        return router

    def _start_robot(self) -> tuple[Process, Witness]:
        node = free_endpoint()
        override = {"ZENOH_CONFIG_OVERRIDE": f'listen/endpoints=["{node}"]'}
        return self._start_simulated(environment=override, address=self.far), NodeWitness(node)

    def _start_simulated(self, environment: dict[str, str] | None = None, **its: str) -> Process:
        chosen = settings(profile="tiago-ros2", scene="load", **its)
        options = ("--connect", self.bus, *chosen, "--set=control_rate=100.0")
        return self._start("services.ros_robot", *options, environment=environment)

    def start_bridge(self) -> Process:
        return self._start(
            "services.bridge_ros2",
            "--connect",
            self.bus,
            *settings(far=self.far, dialect=self.dialect),
            *self._its,
            within=self._within,
        )

    def _plays(self, number: int) -> Iterator[tuple[t.Topic, object]]:
        yield t.COMMAND_EE_TWIST, DOWN
        yield t.COMMAND_BASE_TWIST, FORWARD
        if self.releases and number % 20 == 0:
            yield t.STOP, m.Stop(False, "")

    @property
    def words(self) -> str:
        return f"{self.said[-1].message}" if self.said else "nothing"

    def stopped(self) -> bool:
        return bool(self.said) and self.said[-1].message.mode == "stopped"

    def moves(self) -> None:
        """Released once it can be, it goes."""
        witness = self.witness
        eventually(
            lambda: self.said and witness.arm and witness.base, SOON, lambda: f"the robot is there: {self.words}"
        )
        self.releases = True
        eventually(
            lambda: witness.arm[-1].speed > MOVING and witness.base[-1].speed > MOVING,
            SOON,
            lambda: f"moves: {self.words}",
        )
        self.releases = False
        # A release may be on its way still.
        sent = self.around.turns
        eventually(lambda: self.around.turns > sent + 20)

    def rests_by_itself(self, arms: int, bases: int) -> None:
        """From those samples on arm and base came to rest in time, and stay so.

        Counted in samples, of which the robot's world tells one in each 20 ms of its own: on a busy machine it goes
        slower than the clock of its stamps.
        """
        arm, base = self.witness.arm, self.witness.base
        enough = 1.5 / SAMPLE
        eventually(lambda: min(len(arm) - arms, len(base) - bases) > enough, SOON, "it publishes on")
        lost = (arm[arms + 1 :], base[bases + 1 :])
        took = [last_motion(sample.speed for sample in samples) for samples in lost]
        print(f"arm at rest after {took[0]:.2f} s, base after {took[1]:.2f} s")
        for samples, lost, within in ((arm, arms, ARM_WITHIN), (base, bases, BASE_WITHIN)):
            late = samples[lost + round((within + SAMPLE) / SAMPLE) :]
            assert max(sample.speed for sample in late) < STILL
            assert np.ptp([sample.place for sample in late], axis=0).max() < 0.002


def last_motion(speeds: Iterable[float]) -> float:
    """Time [s] until it is at rest for good."""
    return SAMPLE * max((number + 1 for number, speed in enumerate(speeds) if speed > STILL), default=0)


def settings(**values: str) -> list[str]:
    return [f'--set={name}="{value}"' for name, value in values.items()]


@pytest.fixture
def scene(router: Router, start: StartProcess) -> Iterator[Scene]:
    scene = Scene(router.endpoint, start)
    with scene.around:
        yield scene
    scene.witness.close()


def test_a_killed_bridge_leaves_the_robot_at_rest_and_a_new_one_waits_for_a_person(scene: Scene) -> None:
    scene.moves()
    arms, bases = len(scene.witness.arm) - 1, len(scene.witness.base) - 1
    scene.bridge.kill()
    scene.rests_by_itself(arms, bases)
    said = len(scene.said)
    scene.bridge = scene.start_bridge()
    eventually(lambda: len(scene.said) > said + 5, SOON, "the new one speaks")
    assert scene.stopped(), scene.words
    throughout(lambda: scene.witness.arm[-1].speed < STILL and scene.witness.base[-1].speed < STILL, 0.5)
    scene.moves()


def test_a_hung_bridge_leaves_the_robot_at_rest_and_does_not_go_on_by_itself(scene: Scene) -> None:
    scene.moves()
    arms, bases = len(scene.witness.arm) - 1, len(scene.witness.base) - 1
    scene.bridge.signal(signal.SIGSTOP)
    scene.rests_by_itself(arms, bases)
    said = len(scene.said)
    scene.bridge.signal(signal.SIGCONT)
    eventually(lambda: len(scene.said) > said + 5 and scene.stopped(), SOON, lambda: scene.words)
    assert "the bridge stood still for" in scene.words
    throughout(lambda: scene.witness.arm[-1].speed < STILL and scene.witness.base[-1].speed < STILL, 0.5)
    scene.moves()


def test_without_the_robots_router_it_rests_and_does_not_go_on_by_itself(scene: Scene) -> None:
    scene.moves()
    arms, bases = len(scene.witness.arm) - 1, len(scene.witness.base) - 1
    scene.between.kill()
    scene.rests_by_itself(arms, bases)
    eventually(scene.stopped, SOON, lambda: scene.words)
    joints = scene.around.hear(t.STATE_JOINTS)
    scene.between = scene.start_between()
    eventually(lambda: len(joints) > 10, SOON, lambda: scene.words)
    assert scene.stopped(), scene.words
    throughout(lambda: scene.witness.arm[-1].speed < STILL and scene.witness.base[-1].speed < STILL, 0.5)
    scene.moves()
