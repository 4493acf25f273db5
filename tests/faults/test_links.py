"""Direct links between robot, wrench and controller: cut, jammed, outliving the router and who hangs, made again."""

from __future__ import annotations

import itertools
import signal
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from shared.messages import Stop
from shared.processes import LINKED
from shared.topics import CONTROL_TARGET, STATE_EE, STATE_ROBOT, STOP, WRENCH_EXTERNAL, health_topic
from shared.wire.client import Client
from shared.wire.links import Links
from shared.wire.subscription import Subscription
from shared.wire.zenoh import ZenohBus
from tests.conftest import Router, StartProcess
from tests.faults.chain import PATIENCE
from tests.faults.programs import AHEAD, tared
from tests.support.processes import Process
from tests.support.relay import Crossings
from tests.support.stand_in import StandIn
from tests.support.wait import eventually

pytestmark = pytest.mark.processes
MODULES = {"robot": "mock", "wrench": "wrench", "controller": "controller"}
LEASE = 1.0  # [s] of silence after which a connection is given up
HOGS, BUSY = 5, 10.0
"""Busy programs, and how long [s] they are."""
WITNESS = "base"
"""As whom the test listens: over links of its own, which outlive the router."""


@dataclass
class Linked:
    """Three processes and a witness, whose links can be cut.

    Attributes:
        client: who speaks from outside, through the router alone.
        crossings: where they meet.
        processes: by name.
        robot: what the robot says of itself.
        health: of each of the services.
    """

    router: Router
    start: StartProcess
    state: Path
    client: Client
    crossings: Crossings
    processes: dict[str, Process]
    robot: Subscription
    health: dict[str, Subscription]

    def enter(self, name: str) -> None:
        """Start a process of the chain."""
        options = ("--connect", self.router.endpoint, "--links", self.crossings.patterns[name])
        environment = {"XDG_STATE_HOME": str(self.state)}
        self.processes[name] = self.start(f"services.{MODULES[name]}", *options, environment=environment)

    def moves(self) -> bool:
        return self.robot.latest is not None and self.robot.latest.message.mode == "ready"

    def told(self) -> str:
        """What robot, wrench and controller say is wrong."""
        details = [one.latest.message.detail for one in self.health.values() if one.latest]
        return " | ".join([*details, self.robot.latest.message.reason if self.robot.latest else ""])

    def says(self, text: str) -> None:
        eventually(lambda: text in self.told(), PATIENCE, lambda: f"{text!r} is said: {self.told()}")

    def holds(self) -> None:
        eventually(lambda: not self.moves(), PATIENCE, "the robot holds")

    def stops(self) -> None:
        """A person outside stops the robot."""

        def stopped() -> bool:
            self.client.publish(STOP, Stop(True, "a person"))
            return "a person" in self.told()

        eventually(stopped, PATIENCE, lambda: f"the robot is stopped ({self.told()})")
        self.holds()

    def works(self) -> None:
        eventually(self.moves, PATIENCE, lambda: f"commands are executed ({self.told()})")


@pytest.fixture
def linked(router: Router, start: StartProcess, tmp_path: Path) -> Iterator[Linked]:
    crossings = Crossings((*MODULES, WITNESS))
    with StandIn(router.endpoint, "controller", period=0.1) as stand_in:
        witness = ZenohBus(connect=router.endpoint, links=Links(WITNESS, LINKED, crossings.patterns[WITNESS]))
        witness.link()
        client = Client(witness)
        health = {name: client.watch(health_topic(name)) for name in ("wrench", "controller")}
        robot = client.watch(STATE_ROBOT)
        found = Linked(router, start, tmp_path, stand_in.client, crossings, {}, robot, health)
        for name in MODULES:
            found.enter(name)
        eventually(lambda: tared(stand_in.client), PATIENCE, "the sensor is tared")
        stand_in.plays = lambda _: [(CONTROL_TARGET, AHEAD)]
        found.works()
        yield found
        witness.close()
    crossings.close()


def test_each_message_arrives_once(linked: Linked) -> None:
    health = linked.health["controller"]
    count = health.accepted
    eventually(lambda: health.accepted > count + 4, PATIENCE, "health")
    assert health.latest is not None
    assert health.latest.message.links == {"wrench": True, "robot": True}
    inputs = health.latest.message.inputs
    assert [inputs[topic.key].rejected for topic in (WRENCH_EXTERNAL, STATE_EE)] == [0, 0]


@pytest.mark.parametrize(("source", "sink"), list(itertools.permutations(MODULES, 2)))
def test_a_link_cut_in_one_direction_is_missed_named_and_dialled_again(linked: Linked, source: str, sink: str) -> None:
    linked.crossings.cut(source, sink)
    linked.holds()
    linked.says("no direct link to")
    dialled = linked.crossings.dialled
    linked.crossings.cut(source, sink, passes=True)
    linked.works()
    assert linked.crossings.dialled > dialled


@pytest.mark.parametrize("number", [signal.SIGSTOP, signal.SIGKILL], ids=["hung", "killed"])
def test_nothing_moves_while_nobody_could_stop_it(linked: Linked, number: signal.Signals) -> None:
    """The links stand and commands go on, but no stop would get through any more."""
    linked.router.process.signal(number)
    linked.holds()
    linked.says("nobody could stop the robot: the router")
    if number == signal.SIGSTOP:
        linked.router.process.signal(signal.SIGCONT)
    else:
        linked.router.process.wait()
        linked.start("services.router", "--listen", linked.router.endpoint).wait_for_output("listening")
    linked.works()


@pytest.mark.parametrize("name", MODULES)
def test_a_hung_process_is_linked_again(linked: Linked, name: str) -> None:
    linked.processes[name].signal(signal.SIGSTOP)
    if name == "robot":
        # Who hangs does not say that it holds.
        time.sleep(LEASE + 0.5)
    else:
        linked.holds()
        linked.says(f"no direct link to {name}")
    linked.processes[name].signal(signal.SIGCONT)
    linked.works()
    linked.stops()


def test_whoever_takes_the_place_of_a_hung_process_is_linked_once_that_is_gone(linked: Linked) -> None:
    hung = linked.processes["wrench"]
    hung.signal(signal.SIGSTOP)
    linked.holds()
    linked.enter("wrench")
    linked.says("no direct link to wrench")
    hung.signal(signal.SIGKILL)
    hung.wait()
    linked.works()


def test_a_stop_gets_through_after_a_jam(linked: Linked) -> None:
    """The robot does not read what the router sends it, for a while that is shorter than its lease."""
    robot = linked.processes["robot"]
    robot.signal(signal.SIGSTOP)
    until = time.monotonic() + 0.7 * LEASE
    while time.monotonic() < until:
        linked.client.bus.publish(STOP.key, bytes(40_000))
        time.sleep(0.001)
    robot.signal(signal.SIGCONT)
    linked.works()
    linked.stops()


def test_all_is_well_again_after_the_machine_was_busy(linked: Linked) -> None:
    hogs = [linked.start("tests.support.hog") for _ in range(HOGS)]
    time.sleep(BUSY)
    for hog in hogs:
        hog.signal(signal.SIGKILL)
    linked.works()
    linked.stops()
