"""The controller as a process over a real router: healthy, and with each fault that concerns it."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pytest

from shared.clock import SteadyClock
from shared.messages import ControlStatus, ControlTarget, EndEffector, ExternalWrench, Stop
from shared.parameters import Refused
from shared.topics import (
    COMMAND_EE_TWIST,
    CONTROL_PARAMETERS,
    CONTROL_STATUS,
    CONTROL_TARGET,
    STATE_EE,
    STOP,
    WRENCH_EXTERNAL,
)
from shared.wire.client import Client
from shared.wire.zenoh import ZenohBus
from tests.conftest import Router, StartProcess
from tests.support.processes import Process
from tests.support.stand_in import SPOILT_WRENCHES, StandIn, changed, silently
from tests.support.wait import eventually, throughout

pytestmark = pytest.mark.processes

ERROR = (0.2, 0.2, 0.2, 0.02, 0.02, 0.02)


class Surroundings(StandIn):
    """Robot, wrench service and task in one; collects what the controller says."""

    def __init__(self, endpoint: str) -> None:
        super().__init__(endpoint, "controller")
        self.wrench = np.zeros(6)
        self.valid = True
        self.fault = ""
        self.target = ControlTarget((0.9, 0.0, 1.0), (0, 0, 0, 1), (10.0,) * 3, (3.0,) * 3)
        self.commands = self.hear(COMMAND_EE_TWIST)
        self.statuses = self.hear(CONTROL_STATUS)

    def turn(self, number: int) -> None:
        self.client.publish(STATE_EE, EndEffector((0.5, 0.0, 1.0), (0, 0, 0, 1), np.zeros(3), np.zeros(3)))
        wrench = ExternalWrench(self.wrench[:3], self.wrench[3:], ERROR, "tare", self.fault)
        self.client.publish(WRENCH_EXTERNAL, wrench, self.valid)
        if number % 10 == 0:
            self.client.publish(CONTROL_TARGET, self.target)

    @property
    def status(self) -> ControlStatus | None:
        return self.statuses[-1].message if self.statuses else None

    def moving(self) -> bool:
        """Whether the newest command is fresh, valid and moves towards the target."""
        if not self.commands:
            return False
        last = self.commands[-1]
        fresh = SteadyClock().now_ns() - last.arrival_ns < 100_000_000
        return fresh and last.header.valid and last.message.linear[0] > 0.0

    def braking(self, *parts: str) -> Callable[[], bool]:
        """Whether the newest command is zero and the status brakes for a reason with these parts."""
        return lambda: (
            self.status is not None
            and self.status.state == "braking"
            and all(part in self.status.reason for part in parts)
            and not self.commands[-1].message.linear.any()
        )


@pytest.fixture
def around(shared_router: Router) -> Iterator[Surroundings]:
    with Surroundings(shared_router.endpoint) as surroundings:
        yield surroundings


@pytest.fixture
def controller(shared_router: Router, start: StartProcess) -> Process:
    return start("services.controller", "--connect", shared_router.endpoint, *FORGIVING)


# A shared machine may hold a process up for longer than the default delay; these tests are not about that.
FORGIVING = ("--set", "delay=0.1", "--set", "period=0.1")


def test_healthy(around: Surroundings, controller: Process) -> None:
    eventually(around.moving, 20.0, "a command towards the target")
    assert any(not r.message.linear.any() for r in around.commands), "it began with zero"
    eventually(around.ok, message="health ok")
    assert "controller" in around.bus.living()
    assert around.status.law == "certified" and around.status.solve_us > 0.0
    before = around.turns
    around.commands.clear()
    eventually(lambda: len(around.commands) >= 100, message="a hundred commands")
    assert len(around.commands) == pytest.approx(around.turns - before, rel=0.3), "one for each wrench"


def test_silent_wrench_brakes_and_recovers(around: Surroundings, controller: Process) -> None:
    eventually(around.moving, 20.0)
    around.spoil[WRENCH_EXTERNAL.key] = silently
    onset = SteadyClock().now_ns()
    eventually(around.braking("wrench/external", "Is wrench running?"), message="braking")
    first = next(r for r in around.commands if r.arrival_ns > onset and not r.message.linear.any())
    assert (first.arrival_ns - onset) * 1e-9 < 0.5
    around.spoil.clear()
    eventually(around.moving, message="recovery")


def test_silent_state_brakes_and_recovers(around: Surroundings, controller: Process) -> None:
    eventually(around.moving, 20.0)
    around.spoil[STATE_EE.key] = silently
    eventually(around.braking("state/ee"), message="braking")
    around.spoil.clear()
    eventually(around.moving, message="recovery")


def test_failed_sensor_latches_until_resumed(around: Surroundings, controller: Process) -> None:
    eventually(around.moving, 20.0)
    around.fault, around.valid = "silent", False
    eventually(around.braking("tandem resume"), message="latched")
    around.fault, around.valid = "", True
    throughout(lambda: not around.moving(), 1.0, "it stays braked")
    around.client.publish(STOP, Stop(False, "resume"))
    eventually(around.moving, message="it moves again")


def test_spoilt_wrenches_brake_and_crash_nothing(around: Surroundings, controller: Process) -> None:
    eventually(around.moving, 20.0)
    for name, spoil in SPOILT_WRENCHES.items():
        around.spoil[WRENCH_EXTERNAL.key] = spoil
        eventually(around.braking("wrench/external"), message=f"braking for {name}")
        around.spoil.clear()
        eventually(around.moving, message=f"recovery from {name}")
    twists = np.array([np.concatenate((r.message.linear, r.message.angular)) for r in around.commands])
    assert np.isfinite(twists).all() and np.linalg.norm(twists[:, :3], axis=1).max() <= 0.25 + 1e-9
    eventually(
        lambda: around.refused(WRENCH_EXTERNAL.key) >= len(SPOILT_WRENCHES), message="rejections are counted"
    )
    assert controller.running


def test_second_wrench_publisher_is_refused(
    around: Surroundings, controller: Process, shared_router: Router
) -> None:
    eventually(around.moving, 20.0)
    stranger = ZenohBus(connect=shared_router.endpoint)
    client = Client(stranger)
    try:
        for _ in range(20):
            client.publish(WRENCH_EXTERNAL, ExternalWrench((300.0, 0, 0), np.zeros(3), ERROR, "tare", ""))
            throughout(lambda: around.status.margin[0] > 0, 0.02, "the first publisher's wrench is used")
    finally:
        stranger.close()


def test_bad_target_is_refused_with_the_reason(around: Surroundings, controller: Process) -> None:
    eventually(around.moving, 20.0)
    around.spoil[CONTROL_TARGET.key] = changed(force_limit=[-3.0, 10.0, 10.0])
    eventually(
        lambda: "force_limit" in around.status.reason and "-3" in around.status.reason, message="the reason"
    )
    assert around.moving(), "the last valid target stays in force"


def test_stop_and_resume(around: Surroundings, controller: Process) -> None:
    eventually(around.moving, 20.0)
    around.client.publish(STOP, Stop(True, "hand in the way"))
    eventually(around.braking("hand in the way"), message="braking")
    throughout(lambda: not around.moving(), 0.5, "it stays stopped")
    around.client.publish(STOP, Stop(False))
    eventually(around.moving, message="it moves again")


def test_parameters_over_the_router(around: Surroundings, controller: Process) -> None:
    eventually(around.moving, 20.0)
    with pytest.raises(Refused, match=r"yield_start is 2.*0\.5 to 1"):
        around.client.ask(CONTROL_PARAMETERS, {"set": {"yield_start": 2.0}})
    table = around.client.ask(CONTROL_PARAMETERS, {"set": {"law": "paper"}})["parameters"]
    assert table["law"]["value"] == "paper" and table["yield_start"]["value"] == 1.0
    eventually(lambda: around.status.law == "paper", message="the other law is in force")


def test_ends_on_sigterm_with_a_last_zero(around: Surroundings, controller: Process) -> None:
    eventually(around.moving, 20.0)
    controller.ends_in_time()
    eventually(lambda: not around.commands[-1].message.linear.any(), message="a last zero")


def test_killed_and_started_again_it_begins_from_rest(
    around: Surroundings, controller: Process, shared_router: Router, start: StartProcess
) -> None:
    eventually(around.moving, 20.0)
    controller.kill()
    around.commands.clear()
    start("services.controller", "--connect", shared_router.endpoint, *FORGIVING)
    eventually(around.moving, 20.0, "the second process moves")
    speeds = [r.message.linear[0] for r in around.commands]
    first = next(index for index, speed in enumerate(speeds) if speed > 0)
    assert first >= 1 and speeds[first] <= 2.0 * 0.1


BAD = {
    "period=0.5": ("period", "0.001 to 0.2 s"),
    'law="pid"': ("law", "certified", "paper", "stiffness"),
    "contact_reach=[1.0, 1.0]": ("contact_reach",),
    "zones=[{stiffness=10.0, reach=[9.0, 0.1, 0.1]}]": ("zones[0].reach", "0.001 to 5 m"),
    "bogus=1": ("bogus", "contact_stiffness"),
    "delay=": ("delay",),
}


@pytest.mark.parametrize("assignment", BAD)
def test_bad_configuration_is_one_line_with_status_2(start: StartProcess, assignment: str) -> None:
    start("services.controller", "--set", assignment).refuses(*BAD[assignment])
