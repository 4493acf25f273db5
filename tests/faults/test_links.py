"""Direct links between robot, wrench and controller: cut in either direction, outliving the router, dialled again."""

from __future__ import annotations

import itertools
import os
import signal
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from shared.processes import LINKED
from shared.topics import CONTROL_TARGET, STATE_EE, STATE_ROBOT, WRENCH_EXTERNAL, health_topic
from shared.wire.client import Client
from shared.wire.links import Links
from shared.wire.subscription import Subscription
from shared.wire.zenoh import ZenohBus
from tests.conftest import Router, StartProcess
from tests.faults.chain import PATIENCE
from tests.faults.programs import AHEAD, tared
from tests.support.relay import Crossings
from tests.support.stand_in import StandIn
from tests.support.wait import eventually

pytestmark = [
    pytest.mark.processes,
    pytest.mark.skipif(
        "TANDEM_TRY_LINKS" not in os.environ,
        reason="direct links are on trial: set TANDEM_TRY_LINKS",
    ),
]
MODULES = {"robot": "mock", "wrench": "wrench", "controller": "controller"}
WITNESS = "base"
"""As whom the test listens: over links of its own, which outlive the router."""


@dataclass
class Linked:
    """Three processes and a witness, whose links can be cut.

    Attributes:
        crossings: where they meet.
        robot: what the robot says of itself.
        health: of each of the services.
    """

    router: Router
    start: StartProcess
    crossings: Crossings
    robot: Subscription
    health: dict[str, Subscription]

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

    def works(self) -> None:
        eventually(self.moves, PATIENCE, lambda: f"commands are executed ({self.told()})")


@pytest.fixture
def linked(router: Router, start: StartProcess, tmp_path: Path) -> Iterator[Linked]:
    crossings = Crossings((*MODULES, WITNESS))
    with StandIn(router.endpoint, "controller", period=0.1) as stand_in:
        for name, module in MODULES.items():
            options = ("--connect", router.endpoint, "--links", crossings.patterns[name])
            start(f"services.{module}", *options, environment={"XDG_STATE_HOME": str(tmp_path)})
        witness = ZenohBus(connect=router.endpoint, links=Links(WITNESS, LINKED, crossings.patterns[WITNESS]))
        witness.link()
        client = Client(witness)
        health = {name: client.watch(health_topic(name)) for name in ("wrench", "controller")}
        found = Linked(router, start, crossings, client.watch(STATE_ROBOT), health)
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
