"""Robot and wrench on one machine, controller and operator on another, two routers linked over TLS between them.

Skipped by name where there is no second machine; with TANDEM_MACHINES=required, as in .ci/run, it fails instead.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing, suppress
from itertools import pairwise
from pathlib import Path

import pytest

from services.mock.robot import MAX_ACCELERATION
from shared.messages import ControlTarget
from shared.parameters import Refused
from shared.topics import CONTROL_STATUS, CONTROL_TARGET, STATE_EE, WRENCH_IDENTIFY
from shared.wire.client import Client
from shared.wire.credentials import Credentials
from shared.wire.zenoh import ZenohBus
from tests.faults import programs
from tests.faults.chain import OPTIONS, PATIENCE
from tests.faults.witness import Note, notes
from tests.support import far_machine
from tests.support.far_machine import Direction, FarMachine
from tests.support.ports import free_port
from tests.support.processes import Processes
from tests.support.wait import eventually, throughout

pytestmark = [pytest.mark.processes, pytest.mark.timeout(300)]

RATE = 30.0
"""Of the robot [Hz]: what is late at it is the cable's doing, not a loaded machine's."""
AT_REST = 0.5
"""Time [s] after a cut within which the tool stands: silence, the `ttl`, and what a loaded machine adds."""
CUT = 3.0
"""Time [s] for which the cable is cut: beyond the lease, so that the routers lose each other."""
AHEAD = ControlTarget((8.0, -0.3, 1.0), programs.LEVEL, (25.0,) * 3, (10.0,) * 3)
"""So far away that the tool goes on for as long as any test takes."""


class Both:
    """The two machines and all that runs there.

    Attributes:
        far: where the robot is.
        client: the operator, here.
        witnesses: files of what was heard here, and there.
    """

    def __init__(self, far: FarMachine, processes: Processes, folder: Path) -> None:
        self.far, self._processes = far, processes
        self._keys = folder / "keys"
        making = [sys.executable, "-m", "services.cli", "keys", str(self._keys), "--name", far.address]
        subprocess.run(making, check=True, capture_output=True)
        there, here = f"tls/{far.address}:{free_port()}", f"tls/127.0.0.1:{free_port()}"
        self._router("--listen", there, within=far.within)
        self._router("--listen", here, "--link", there)
        self._service("mock", there, "--set", f"rate={RATE}", within=far.within)
        self._service("wrench", there, *OPTIONS["wrench"], within=far.within)
        self._service("controller", here, *OPTIONS["controller"])
        self.witnesses = folder / "here", folder / "there"
        for file, endpoint, within in zip(self.witnesses, (here, there), ((), far.within), strict=True):
            arguments = endpoint, str(file), str(self._keys / "viewer")
            processes.start("tests.faults.witness", *arguments, within=within).wait_for_output("witnessing")
        self.bus = ZenohBus(connect=here, credentials=Credentials.of(str(self._keys / "experiment")))
        self.client = Client(self.bus)
        self.status = self.client.watch(CONTROL_STATUS)
        self.tool = self.client.watch(STATE_EE)

    def _router(self, *options: str, within: tuple[str, ...] = ()) -> None:
        arguments = (*options, "--secure", str(self._keys / "router"))
        self._processes.start("services.router", *arguments, within=within).wait_for_output("listening")

    def _service(self, name: str, endpoint: str, *options: str, within: tuple[str, ...] = ()) -> None:
        arguments = ("--connect", endpoint, "--secure", str(self._keys / name), *options)
        self._processes.start(f"services.{name}", *arguments, within=within)

    def aim(self) -> bool:
        """Say where to go, as an operator does again and again."""
        self.client.publish(CONTROL_TARGET, AHEAD)
        return True

    def says(self) -> str:
        """What the controller says."""
        latest = self.status.latest
        return "nothing" if latest is None else f"{latest.message.state}: {latest.message.reason}"

    def moves(self) -> None:
        """Wait until the tool is seen moving from here."""

        def moving() -> bool:
            self.aim()
            latest = self.tool.latest
            fresh = latest is not None and self.tool.age(self.tool.now_ns()) < 0.5
            return fresh and latest.message.linear[0] > 0.01

        eventually(moving, PATIENCE, self.says)

    def heard_there(self, key: str) -> list[Note]:
        """All of a key that was heard beside the robot."""
        return [note for note in notes(self.witnesses[1]) if note.key == key]


@pytest.fixture(scope="module")
def both(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Both]:
    if why := far_machine.unusable():
        (pytest.fail if os.environ.get("TANDEM_MACHINES") == "required" else pytest.skip)(why)
    folder = tmp_path_factory.mktemp("machines")
    with ExitStack() as open_:
        far = open_.enter_context(FarMachine())
        made = Both(far, open_.enter_context(Processes(folder)), folder)
        open_.enter_context(closing(made.bus))
        eventually(lambda: programs.tared(made.client), PATIENCE, "the sensor is tared")
        yield made


def test_what_is_asked_over_the_link_is_done_once(both: Both) -> None:
    taken = []

    def enough() -> bool:
        # A machine that is too slow for its rate refuses to average.
        with suppress(Refused):
            taken.append(both.client.ask(WRENCH_IDENTIFY, {"action": "add"}, timeout=10.0)["poses"])
        return len(taken) == 5

    both.client.ask(WRENCH_IDENTIFY, {"action": "start"})
    try:
        eventually(enough, PATIENCE, both.says)
    finally:
        both.client.ask(WRENCH_IDENTIFY, {"action": "cancel"})
    assert taken == [1, 2, 3, 4, 5]


@pytest.mark.parametrize("direction", ["there", "back"])
def test_a_link_that_is_cut_stops_the_robot_which_goes_on_by_itself(both: Both, direction: Direction) -> None:
    both.moves()
    both.far.lose(direction, 1.0)
    cut = time.monotonic()
    try:
        throughout(both.aim, CUT)
        mended = time.monotonic()
    finally:
        both.far.mend()
    both.moves()
    tool = both.heard_there(STATE_EE.key)
    silent = [note for note in tool if cut + AT_REST < note.time < mended]
    assert len(silent) > 10 and not any(note.speed for note in silent)
    assert any(note.speed for note in tool if note.time < cut)
    rises = [(after.speed - before.speed) / (after.stamp - before.stamp) for before, after in pairwise(tool)]
    # A step of the robot is as long as its process was made to wait, the stamps a little less evenly.
    assert max(rises) < 2.0 * MAX_ACCELERATION


def test_lost_packets_double_nothing_and_are_lived_with(both: Both) -> None:
    both.far.lose("there", 0.05)
    both.far.lose("back", 0.05)
    try:
        before = both.tool.accepted
        eventually(lambda: both.aim() and both.tool.accepted > before + 5 * RATE, PATIENCE, both.says)
    finally:
        both.far.mend()
    both.moves()
    for file in both.witnesses:
        newest: dict[tuple[str, int], int] = {}
        for note in notes(file):
            assert note.number > newest.get((note.key, note.session), -1), note
            newest[note.key, note.session] = note.number
        assert {key for key, _ in newest} == {"sensor/ft", "state/ee", "wrench/external", "command/ee_twist"}
