"""Each program of misbehaviour against the same two service processes: they brake or carry on, and always recover."""

from __future__ import annotations

import signal

import pytest

from shared.topics import SENSOR_FT
from tests.faults.chain import PATIENCE, Chain, running
from tests.support.wait import eventually, throughout

pytestmark = pytest.mark.processes

BRAKES = [
    "silent_robot",
    "silent_tool",
    "nan_sensor",
    "infinite_tool",
    "garbage",
    "wrong_fields",
    "oversized",
    "burst",
    "late",
    "liar_stamp",
    "invalid_sensor",
]
"""The controller brakes while it lasts and resumes by itself afterwards."""
LATCHES = {"silent_sensor": "silent", "stuck_sensor": "stuck", "saturated_sensor": "saturated"}
"""A failure of the sensor alone: braking stays until a person releases it. Program -> the word for it."""
CARRIES_ON = ["garbage_between", "duplicates", "lossy"]


@pytest.mark.parametrize("name", BRAKES)
def test_brakes_and_resumes(chain: Chain, name: str) -> None:
    with chain.misbehaving(name) as program:
        chain.brakes()
        assert chain.watch.reason
        program.signal(signal.SIGUSR2)
        chain.works("it resumes by itself")


@pytest.mark.parametrize("name", LATCHES)
def test_brakes_and_stays_so_until_released(chain: Chain, name: str) -> None:
    with chain.misbehaving(name) as program:
        chain.brakes()
        eventually(lambda: "latched" in chain.watch.reason, PATIENCE, "braking is latched")
        assert LATCHES[name] in chain.watch.reason and "tandem resume" in chain.watch.reason
        program.signal(signal.SIGUSR2)
        eventually(chain.ok, PATIENCE, "the sensor is back")
        count = len(chain.watch.commands)
        throughout(lambda: chain.watch.moved_since(count) == 0, 1.0, "no motion before the release")
        chain.release()
        chain.works("it resumes after the release")


@pytest.mark.parametrize("name", CARRIES_ON)
def test_carries_on(chain: Chain, name: str) -> None:
    with chain.misbehaving(name):
        before = chain.refused(SENSOR_FT.key)
        count = len(chain.watch.commands)
        eventually(lambda: chain.watch.moved_since(count) >= 60, PATIENCE, "it keeps moving")
        if name != "lossy":
            eventually(lambda: chain.refused(SENSOR_FT.key) > before + 50, PATIENCE, "refusals counted")


def test_a_sequence_far_ahead_is_survived_without_help(chain: Chain) -> None:
    with chain.misbehaving("jumping_sequence"):
        chain.brakes()
        chain.works("the true sequence is followed again")


def test_heavy_loss_brakes(chain: Chain) -> None:
    with chain.misbehaving("very_lossy") as program:
        chain.brakes()
        program.signal(signal.SIGUSR2)
        # More than 100 ms without a sample, while the tool's pose came through, may have been among it: a latch.
        eventually(chain.ok, PATIENCE, "the samples come through")
        chain.release()
        chain.works("it resumes")


def test_a_flood_harms_nothing(chain: Chain) -> None:
    with chain.misbehaving("flood") as program:
        throughout(chain.unharmed_so_far, 2.0, "the services live through it")
        program.signal(signal.SIGUSR2)
        chain.works("it resumes by itself")


def test_a_flood_of_queries_does_not_stop_the_tool(chain: Chain) -> None:
    with chain.playing():
        with running(chain.program("tests.faults.strangers", "query_flood")) as flood:
            flood.wait_for_output("playing")
            count = len(chain.watch.commands)
            eventually(lambda: chain.watch.moved_since(count) >= 60, PATIENCE, "it keeps moving")
            assert flood.running
        chain.works()


def test_a_second_publisher_is_refused_and_counted(chain: Chain) -> None:
    with chain.playing():
        before = chain.refused(SENSOR_FT.key)
        with running(chain.program("tests.faults.strangers", "second_publisher")):
            eventually(lambda: chain.refused(SENSOR_FT.key) > before + 50, PATIENCE, "refusals counted")
        chain.works("the first one is heard")


def test_a_restarted_robot_is_followed(chain: Chain) -> None:
    for _ in range(2):
        with chain.playing() as program:
            program.kill()
            chain.brakes()
            assert "latched" not in chain.watch.reason


def test_a_robot_that_hangs_and_wakes_is_followed(chain: Chain) -> None:
    with chain.playing() as program:
        program.signal(signal.SIGSTOP)
        chain.brakes()
        program.signal(signal.SIGCONT)
        chain.works("the woken robot moves")
