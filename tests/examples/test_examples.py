"""The examples do what they say, over a real router and beside the services as they are."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from shared.messages import ControlTarget, Stop
from shared.parameters import Refused
from shared.topics import CONTROL_TARGET, STATE_EE, STATE_ROBOT, STOP, WRENCH_EXTERNAL, WRENCH_TARE
from shared.wire.bus import NoReply
from shared.wire.client import Client
from shared.wire.zenoh import ZenohBus
from tests.conftest import Router, StartProcess
from tests.support.processes import ROOT
from tests.support.wait import eventually, throughout

pytestmark = [pytest.mark.processes, pytest.mark.timeout(180)]
PATIENCE = 60.0  # [s]


@pytest.fixture
def client(router: Router) -> Iterator[Client]:
    with closing(ZenohBus("tiago", router.endpoint)) as bus:
        yield Client(bus, name="hold")


def tare(client: Client) -> bool:
    try:
        return bool(client.ask(WRENCH_TARE, {"duration": 0.5}, timeout=4.0))
    except (NoReply, Refused):
        return False


def test_they_are_short() -> None:
    for example in sorted((Path(ROOT) / "examples").glob("*.py")):
        lines = [line for line in example.read_text().partition('"""\n')[2].splitlines() if line.strip()]
        assert len(lines) <= 40, example


def test_a_controller_of_ones_own_moves_with_the_force_and_stops_behind_the_gate(
    router: Router, client: Client, start: StartProcess
) -> None:
    place = ("--connect", router.endpoint)
    start("services.mock", *place, "--set", "wrench=[40.0, 0.0, 0.0, 0.0, 0.0, 0.0]")
    start("services.wrench", *place)
    start("examples.admittance", *place, "--set", "damping=500")
    tool, robot = client.watch(STATE_EE), client.watch(STATE_ROBOT)
    eventually(lambda: tool.latest and tool.latest.message.position[0] > 0.55, PATIENCE, "it gives way along x")
    assert tool.latest is not None and abs(tool.latest.message.position[1] + 0.3) < 0.01

    def stopped() -> bool:
        client.publish(STOP, Stop(engaged=True, reason="test"))
        return robot.latest is not None and robot.latest.message.mode == "stopped"

    eventually(stopped, PATIENCE, "the gate stops it")
    eventually(lambda: tool.latest and not tool.latest.message.linear.any(), PATIENCE, "it stands")
    throughout(lambda: tool.latest and not tool.latest.message.linear.any(), 0.3, "a command moves nothing")


def test_a_robot_of_ones_own_is_held_within_the_limit_at_its_wall(
    router: Router, client: Client, start: StartProcess
) -> None:
    place = ("--connect", router.endpoint)
    start("examples.robot_at_a_wall", *place)
    start("services.wrench", *place)
    start("services.controller", *place)
    wrench = client.watch(WRENCH_EXTERNAL)
    eventually(lambda: tare(client), PATIENCE, "the sensor is tared")
    target = ControlTarget((0.7, -0.3, 1.0), (0.0, 0.0, 0.0, 1.0), (10.0,) * 3, (10.0,) * 3)
    felt: list[float] = []

    def pushed() -> bool:
        client.publish(CONTROL_TARGET, target)
        assert wrench.latest is not None
        force, bound = wrench.latest.message.force[0], wrench.latest.message.error_bound[0]
        felt.append(force)
        assert -force <= 10.0 + bound
        return len(felt) > 200 and np.ptp(felt[-100:]) < 0.5 and -force > 5.0

    eventually(pushed, PATIENCE, lambda: f"it rests at the wall, last felt {felt[-3:]}")


@pytest.mark.slow
def test_a_script_holds_pushes_and_reads(router: Router, start: StartProcess) -> None:
    place = ("--connect", router.endpoint)
    for service in ("sim", "wrench", "controller"):
        start(f"services.{service}", *place)
    outputs: list[str] = []

    def done() -> bool:
        # It says so and ends where the stack does not work yet, or a sample was late in its tare.
        script = start("examples.hold_push_read", router.endpoint)
        status = script.wait(PATIENCE)
        outputs.append(script.output)
        assert status == 0 or script.output.count("\n") == 1, script.output
        return status == 0

    eventually(done, 2 * PATIENCE, lambda: outputs[-1])
    found = re.findall(r"^ *(\S+) N hang from it: force z +(\S+) N, tool at (\S+) m$", outputs[-1], re.MULTILINE)
    rows = np.array(found, float)
    assert rows[:, 0].tolist() == [0.0, 10.0, 0.0]
    assert rows[:, 1] == pytest.approx([0.0, -10.0, 0.0], abs=2.0)
    assert np.ptp(rows[:, 2]) < 0.05
