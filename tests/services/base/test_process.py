"""The base service as a process over a real router: healthy, and with each fault that concerns it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from shared.messages import ExternalWrench, Stop
from shared.parameters import Refused
from shared.topics import (
    BASE_ENABLE,
    BASE_PARAMETERS,
    STATE_EE,
    STATE_ROBOT,
    STOP,
    WRENCH_EXTERNAL,
    Topic,
)
from shared.wire.client import Client
from shared.wire.zenoh import ZenohBus
from tests.conftest import Router, StartProcess
from tests.services.base.surroundings import Surroundings
from tests.support.processes import Process
from tests.support.stand_in import SPOILT_WRENCHES, silently
from tests.support.wait import eventually, throughout

pytestmark = pytest.mark.processes

PROMISE = 0.12
"""Time [s] from the last sound sample to a braking command."""
ON_TIME = 0.02
"""Time [s] between two turns of the test's own thread beyond which a measurement says nothing about the service."""


@pytest.fixture
def around(shared_router: Router) -> Iterator[Surroundings]:
    with Surroundings(shared_router.endpoint) as surroundings:
        yield surroundings


# A shared machine may hold a process up for longer than the default delay; these tests are not about that.
FORGIVING = ("--set", "max_delay=0.2")


@pytest.fixture
def base(shared_router: Router, start: StartProcess) -> Process:
    return start("services.base", "--connect", shared_router.endpoint, *FORGIVING)


def test_healthy(around: Surroundings, base: Process) -> None:
    eventually(around.moving, 20.0, "a command with the force")
    assert not around.commands[0].message.velocity.any(), "it began with zero"
    eventually(around.ok, message="health ok")
    assert "base" in around.bus.living()
    assert around.status is not None and around.status.state == "following"
    assert around.status.wrench == pytest.approx((6.0, 0.0, 0.0))
    before = around.turns
    around.commands.clear()
    eventually(lambda: len(around.commands) >= 100, message="a hundred commands")
    assert len(around.commands) == pytest.approx(around.turns - before, rel=0.3), "one for each wrench"
    eventually(
        lambda: around.commands[-1].message.velocity == pytest.approx((0.25, 0.0, 0.0), abs=1e-3),
        message="(6 - 1) N over 20 N s/m",
    )
    around.unharmed()


@pytest.mark.parametrize("kind", ["silent", "invalid"])
def test_a_lost_wrench_brakes_within_the_promised_time_and_recovers(
    around: Surroundings, base: Process, kind: str
) -> None:
    measured = None
    for _ in range(10):
        eventually(around.moving, 20.0)
        around.lateness = 0.0
        if kind == "silent":
            around.spoil[WRENCH_EXTERNAL.key] = silently
        else:
            around.valid = False
        eventually(lambda: around.status is not None and around.status.state == "braking", message="braking")
        onset, punctual = around.last_sound_ns, around.lateness < ON_TIME
        eventually(around.braked("wrench/external"), message="rest")
        around.spoil.clear()
        around.valid = True
        if punctual:
            first = next(r for r in around.commands if r.arrival_ns > onset and not r.header.valid)
            measured = (first.arrival_ns - onset) * 1e-9
            break
    assert measured is not None, "the machine never ran the test itself on time"
    assert measured <= PROMISE
    eventually(around.moving, message="recovery")
    around.unharmed()


@pytest.mark.parametrize("topic", [STATE_EE, STATE_ROBOT], ids=lambda topic: topic.key)
def test_a_silent_robot_brakes_and_recovers(around: Surroundings, base: Process, topic: Topic) -> None:
    eventually(around.moving, 20.0)
    around.spoil[topic.key] = silently
    eventually(around.braked(topic.key), message="braking")
    around.spoil.clear()
    eventually(around.moving, message="recovery")


@pytest.mark.parametrize(
    "topic", [WRENCH_EXTERNAL, STATE_EE, STATE_ROBOT, BASE_ENABLE], ids=lambda topic: topic.key
)
def test_an_input_never_seen_means_no_motion(
    around: Surroundings, shared_router: Router, start: StartProcess, topic: Topic
) -> None:
    around.spoil[topic.key] = silently
    start("services.base", "--connect", shared_router.endpoint, *FORGIVING)
    eventually(lambda: around.status is not None, 20.0, "it speaks")
    throughout(lambda: around.resting() and around.status.state == "off", 1.0, "no motion")
    if topic != BASE_ENABLE:
        eventually(lambda: f"{topic.key}: never received" in around.detail, message="the reason")
    around.spoil.clear()
    eventually(around.moving, message="motion once it is there")


def test_disabled_and_enabled_again(around: Surroundings, base: Process) -> None:
    eventually(around.moving, 20.0)
    around.enabled = False
    eventually(lambda: around.status.state == "off" and around.resting(), message="off")
    around.enabled = True
    eventually(around.moving, message="it moves again")
    around.spoil[BASE_ENABLE.key] = silently
    eventually(lambda: around.status.state == "off" and around.resting(), message="off for silence")
    around.unharmed()


def test_failed_sensor_latches_until_resumed(around: Surroundings, base: Process) -> None:
    eventually(around.moving, 20.0)
    around.fault, around.valid = "silent", False
    eventually(around.braked("silent"), message="at rest")
    throughout(around.braked("silent"), 0.5, "for longer than it takes to latch")
    around.fault, around.valid = "", True
    eventually(around.braked("tandem resume"), message="latched")
    throughout(lambda: not around.moving(), 1.0, "it stays braked")
    around.client.publish(STOP, Stop(False, "resume"))
    eventually(around.moving, message="it moves again")


def test_stop_and_resume(around: Surroundings, base: Process) -> None:
    eventually(around.moving, 20.0)
    around.client.publish(STOP, Stop(True, "hand in the way"))
    eventually(lambda: around.resting() and around.status.state == "off", message="at rest")
    eventually(lambda: "hand in the way" in around.detail, message="the reason")
    throughout(lambda: not around.moving(), 0.5, "it stays stopped")
    around.client.publish(STOP, Stop(False))
    eventually(around.moving, message="it moves again")


def test_spoilt_wrenches_brake_and_crash_nothing(around: Surroundings, base: Process) -> None:
    eventually(around.moving, 20.0)
    for name, spoil in SPOILT_WRENCHES.items():
        around.spoil[WRENCH_EXTERNAL.key] = spoil
        eventually(around.braked("wrench/external"), message=f"braking for {name}")
        around.spoil.clear()
        eventually(around.moving, message=f"recovery from {name}")
    eventually(
        lambda: around.refused(WRENCH_EXTERNAL.key) >= len(SPOILT_WRENCHES), message="rejections are counted"
    )
    around.unharmed()
    assert base.running


def test_a_second_publisher_is_refused(around: Surroundings, base: Process, shared_router: Router) -> None:
    eventually(around.moving, 20.0)
    stranger = ZenohBus(connect=shared_router.endpoint)
    client = Client(stranger)

    def refused() -> bool:
        # Sent until enough have been refused: nobody promises that each of them arrives.
        client.publish(WRENCH_EXTERNAL, ExternalWrench((-300.0, 0, 0), np.zeros(3), (0.2,) * 6, "tare", ""))
        assert around.status.wrench[0] == pytest.approx(6.0), "the first one's is used"
        return around.refused(WRENCH_EXTERNAL.key) >= 20

    try:
        eventually(refused, message="refusals are counted")
    finally:
        stranger.close()


def test_parameters_over_the_router(around: Surroundings, base: Process) -> None:
    eventually(around.moving, 20.0)
    with pytest.raises(Refused, match=r"mass is 1000.*1 to 200 kg"):
        around.client.ask(BASE_PARAMETERS, {"set": {"mass": 1000.0}})
    table = around.client.ask(BASE_PARAMETERS, {"set": {"max_linear": 0.1}})["parameters"]
    assert table["max_linear"]["value"] == 0.1 and table["mass"]["value"] == 10.0
    slower = lambda: around.commands[-1].message.velocity[0] == pytest.approx(0.1, abs=1e-3)  # noqa: E731
    eventually(slower, message="the lower limit is in force")


def test_ends_on_sigterm_with_a_last_zero(around: Surroundings, base: Process) -> None:
    eventually(around.moving, 20.0)
    base.ends_in_time()
    eventually(around.resting, message="a last zero")


def test_killed_and_started_again_it_begins_from_rest(
    around: Surroundings, base: Process, shared_router: Router, start: StartProcess
) -> None:
    eventually(around.moving, 20.0)
    base.kill()
    around.commands.clear()
    start("services.base", "--connect", shared_router.endpoint, *FORGIVING)
    eventually(around.moving, 20.0, "the second process moves")
    assert around.commands[0].message.velocity[0] == 0.0
    around.unharmed()


BAD = {
    "mass=0.0": ("mass", "1 to 200 kg"),
    "max_linear=1.5": ("max_linear", "0.01 to 1 m/s"),
    'damping_linear="much"': ("damping_linear", "a finite number"),
    "inertia=[1.0, 2.0]": ("inertia",),
    "bogus=1": ("bogus", "damping_angular"),
    "mass=": ("mass",),
}


@pytest.mark.parametrize("assignment", BAD)
def test_bad_configuration_is_one_line_with_status_2(start: StartProcess, assignment: str) -> None:
    start("services.base", "--set", assignment).refuses(*BAD[assignment])
