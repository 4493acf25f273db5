"""The wrench service as a process over a real router: healthy, and with each fault that concerns it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path

import msgpack
import numpy as np
import pytest

from shared.clock import SteadyClock
from shared.messages import ExternalWrench
from shared.parameters import Refused
from shared.topics import SENSOR_FT, WRENCH_EXTERNAL, WRENCH_TARE
from shared.wire.subscription import Received
from tests.conftest import Router, StartProcess
from tests.services.wrench.sensor import LEVEL, Sensor
from tests.support.ports import free_endpoint
from tests.support.processes import Process
from tests.support.stand_in import Spoil, StandIn, changed, silently
from tests.support.wait import eventually, throughout

pytestmark = pytest.mark.processes


class Robot(StandIn):
    """Publishes made-up samples, and collects what the wrench service makes of them."""

    def __init__(self, endpoint: str) -> None:
        super().__init__(endpoint, "wrench")
        self.sensor = Sensor()
        self.external = np.zeros(6)
        self.saturated = False
        self.received: list[Received[ExternalWrench]] = []
        self.subscription = self.client.watch(WRENCH_EXTERNAL, self.received.append)

    def turn(self, number: int) -> None:
        self.client.publish(SENSOR_FT, self.sensor.sample(LEVEL, self.external, self.saturated))

    @property
    def last(self) -> Received[ExternalWrench] | None:
        return self.received[-1] if self.received else None

    def healthy(self) -> bool:
        """Whether a valid wrench came in within the last few periods."""
        return (
            self.last is not None
            and self.last.header.valid
            and self.subscription.age(SteadyClock().now_ns()) < 0.1
            and self.last.message.fault == ""
        )

    def faulty(self, fault: str) -> Callable[[], bool]:
        return lambda: (
            self.last is not None and not self.last.header.valid and self.last.message.fault == fault
        )


@pytest.fixture
def robot(shared_router: Router) -> Iterator[Robot]:
    with Robot(shared_router.endpoint) as robot:
        yield robot


@pytest.fixture
def wrench(shared_router: Router, start: StartProcess, tmp_path: Path) -> Process:
    return launch(shared_router, start, tmp_path)


def launch(shared_router: Router, start: StartProcess, state: Path, *options: str) -> Process:
    return start(
        "services.wrench",
        "--connect",
        shared_router.endpoint,
        *options,
        environment={"XDG_STATE_HOME": str(state)},
    )


def tared(robot: Robot) -> dict:
    """The answer to a tare; a busy machine may spoil one, not every one."""

    def attempt() -> dict | None:
        try:
            return robot.client.ask(WRENCH_TARE, {"duration": 0.3}, timeout=10.0)
        except Refused as refusal:
            assert "sensor/ft" in str(refusal)
            return None

    return eventually(attempt, 60.0, "a tare")


def without(field: str) -> Spoil:
    def remove(payload: bytes) -> bytes:
        content = msgpack.unpackb(payload)
        del content[field]
        return msgpack.packb(content)

    return remove


def test_one_valid_wrench_per_sample_and_an_honest_health(robot: Robot, wrench: Process) -> None:
    eventually(robot.healthy, 20.0, "a valid wrench")
    eventually(robot.ok, message="health ok")
    robot.received.clear()
    first = robot.turns
    eventually(lambda: len(robot.received) >= 100, message="a hundred wrenches")
    assert robot.turns - first >= len(robot.received) - 2
    assert "wrench" in robot.bus.living()
    wanted = robot.sensor.exact(LEVEL)[:3]
    errors = np.array([r.message.force - wanted for r in robot.received])
    assert errors.mean(axis=0) == pytest.approx(np.zeros(3), abs=0.1)


def test_tare_over_the_router(robot: Robot, wrench: Process) -> None:
    eventually(robot.healthy, 20.0, "a valid wrench")
    answer = tared(robot)
    assert answer["samples"] >= 10
    eventually(lambda: robot.last and robot.last.message.compensation == "tare", message="the tare in force")
    robot.external = np.array((0.0, 0.0, -9.81, 0.0, 0.0, 0.0))
    eventually(
        lambda: robot.last and abs(robot.last.message.force[2] + 9.81) < robot.last.message.error_bound[2],
        message="one hanging kilogram reads -9.81 N",
    )
    with pytest.raises(Refused, match="duration"):
        robot.client.ask(WRENCH_TARE, {"duration": math.inf})


def test_silence(robot: Robot, wrench: Process) -> None:
    eventually(robot.healthy, 20.0, "a valid wrench")
    robot.spoil[SENSOR_FT.key] = silently
    eventually(robot.faulty("silent"), message="fault silent")
    robot.received.clear()
    eventually(lambda: len(robot.received) >= 10, message="it goes on saying so")
    gaps = np.diff([r.arrival_ns for r in robot.received]) * 1e-9
    assert np.median(gaps) == pytest.approx(0.05, rel=0.3)
    robot.spoil.clear()
    eventually(robot.healthy, message="recovery")


SPOILT = {
    "NaN": changed(force=[math.nan, 0.0, 0.0]),
    "infinity": changed(torque=[0.0, -math.inf, 0.0]),
    "text": changed(force="strong"),
    "too short": changed(force=[1.0, 2.0]),
    "too long": changed(torque=[1.0] * 4),
    "missing": without("orientation"),
    "no rotation": changed(orientation=[0.0, 0.0, 0.0, 0.0]),
    "no header": without("seq"),
    "number for bool": changed(saturated=1),
    "not a map": lambda payload: msgpack.packb([1, 2, 3]),
    "garbage": lambda payload: bytes(reversed(payload)),
    "empty": lambda payload: b"",
    "megabyte": lambda payload: payload + bytes(1_000_000),
}


def test_every_spoilt_sample_is_rejected_and_crashes_nothing(robot: Robot, wrench: Process) -> None:
    eventually(robot.healthy, 20.0, "a valid wrench")
    for name, spoil in SPOILT.items():
        robot.spoil[SENSOR_FT.key] = spoil
        # A hundred megabytes per second may get no further than the network's queues.
        words = ("invalid", "silent") if name == "megabyte" else ("invalid",)
        eventually(
            lambda words=words: any(robot.faulty(word)() for word in words),
            message=f"a sensor that sends {name} is {' or '.join(words)}",
        )
        robot.spoil.clear()
        eventually(robot.healthy, message=f"recovery from {name}")
    values = np.array([np.concatenate((r.message.force, r.message.torque)) for r in robot.received])
    assert np.all(np.isfinite(values)) and np.abs(values).max() < 50.0
    eventually(lambda: robot.refused(SENSOR_FT.key) >= len(SPOILT), message="rejections are counted")
    assert wrench.running


def test_stuck_axis(robot: Robot, wrench: Process) -> None:
    eventually(robot.healthy, 20.0, "a valid wrench")
    frozen = robot.sensor.sample().force.tolist()
    robot.spoil[SENSOR_FT.key] = changed(force=frozen)
    eventually(robot.faulty("stuck"), message="fault stuck")
    robot.spoil.clear()
    eventually(robot.healthy, message="recovery")


def test_saturation(robot: Robot, wrench: Process) -> None:
    eventually(robot.healthy, 20.0, "a valid wrench")
    robot.saturated = True
    eventually(robot.faulty("saturated"), message="fault saturated")
    robot.saturated = False
    eventually(robot.healthy, message="recovery")


def test_old_and_repeated_samples_are_dropped_and_counted(robot: Robot, wrench: Process) -> None:
    eventually(robot.healthy, 20.0, "a valid wrench")
    robot.spoil[SENSOR_FT.key] = changed(seq=3)
    eventually(robot.faulty("silent"), message="nothing new came in")
    robot.spoil.clear()
    eventually(robot.healthy, message="recovery")
    eventually(lambda: robot.refused(SENSOR_FT.key) > 0, message="counted")


def test_second_publisher_is_refused(robot: Robot, wrench: Process, shared_router: Router) -> None:
    eventually(robot.healthy, 20.0, "a valid wrench")
    stranger = Robot(shared_router.endpoint)
    stranger.external = np.array((0.0, 0.0, 500.0, 0.0, 0.0, 0.0))
    with stranger:
        throughout(lambda: abs(robot.last.message.force[2]) < 100.0, 0.5, "the first publisher is used")


def test_killed_and_started_again_it_goes_on_with_its_tare(
    robot: Robot, shared_router: Router, start: StartProcess, tmp_path: Path
) -> None:
    first = launch(shared_router, start, tmp_path)
    eventually(robot.healthy, 20.0, "a valid wrench")
    tared(robot)
    bag = np.array((0.0, 0.0, -20.0, 0.0, 0.0, 0.0))
    robot.external = bag
    first.kill()
    robot.received.clear()
    launch(shared_router, start, tmp_path)
    eventually(robot.healthy, 20.0, "a valid wrench of the second process")
    for received in robot.received:
        if received.header.valid:
            assert received.message.compensation == "tare"
            assert np.all(np.abs(received.message.force - bag[:3]) <= 1.0)


def test_waits_for_a_router_that_starts_later(start: StartProcess, tmp_path: Path) -> None:
    endpoint = free_endpoint()
    process = start("services.wrench", "--connect", endpoint, environment={"XDG_STATE_HOME": str(tmp_path)})
    process.wait_for_output("waiting for a Zenoh router")
    start("services.router", "--listen", endpoint).wait_for_output("listening")
    with Robot(endpoint) as robot:
        eventually(robot.healthy, 20.0, "a valid wrench")


def test_ends_on_sigterm_within_two_seconds(robot: Robot, wrench: Process) -> None:
    eventually(robot.healthy, 20.0, "a valid wrench")
    wrench.ends_in_time()


BAD = {
    "lowpass_hz=-1.0": ("lowpass_hz", "0 to 1000 Hz"),
    "stuck_after=0.0": ("stuck_after", "0.02 to 1 s"),
    "noise_bound=[1.0, 1.0]": ("noise_bound",),
    "noise_bound=[0.5, 0.5, 0.5, 0.0, 0.1, 0.1]": ("noise_bound", "1e-06 to 100"),
    "bogus=1": ("bogus", "noise_bound"),
    'payload="/no/such/file.toml"': ("payload", "/no/such/file.toml", "No such file"),
}


@pytest.mark.parametrize("assignment", BAD)
def test_bad_configuration_is_one_line_with_status_2(start: StartProcess, assignment: str) -> None:
    start("services.wrench", "--set", assignment).refuses(*BAD[assignment])
