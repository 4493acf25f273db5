"""Stops and latched sensor failures keep a service at rest until a valid release.

A failure of the sensor is latched about 100 ms after its last healthy wrench, whatever is reported in between.
"""

from __future__ import annotations

import pytest

from shared import faults
from shared.faults import Fault
from shared.loop.halt import Halt, SensorLatch
from shared.messages import Header, Stop
from shared.service import Inputs, Reading
from shared.topics import STATE_EE, STOP, WRENCH_EXTERNAL

WRENCH = WRENCH_EXTERNAL.key
BLAMED = faults.invalid(WRENCH, "silent")
SILENT = faults.silent(WRENCH, "wrench", 0.05, 0.03)
DELAYED = faults.delayed(WRENCH, 0.05, 0.03)
LOSSY = faults.lossy(WRENCH, 0.5, 0.3)
NO_ROBOT = faults.silent(STATE_EE.key, "the robot", 0.2, 0.1)


def latched_after(*calls: tuple[float, Fault | None]) -> float | None:
    """Time [s] since the last healthy wrench of the call that latched; None stands for a healthy one."""
    latch, time = SensorLatch(), 0.0
    for dt, fault in calls:
        time += dt
        if fault is None:
            latch.healthy()
        else:
            latch.fault(fault, dt)
        if latch.reason:
            return time
    return None


@pytest.mark.parametrize(
    ("calls", "time"),
    [
        # As the wrench service reports: first 30 ms after the last sample, then every 50 ms.
        ([(0.03, BLAMED), (0.05, BLAMED), (0.05, BLAMED)], 0.13),
        # In between its own message counts as silent, before or after the other.
        ([(0.03, SILENT), (0.001, BLAMED), (0.049, SILENT), (0.001, BLAMED), (0.049, SILENT)], 0.13),
        ([(0.03, BLAMED), (0.03, SILENT), (0.02, BLAMED), (0.05, SILENT)], 0.13),
        ([(0.03, BLAMED), (0.03, DELAYED), (0.02, BLAMED), (0.05, LOSSY)], 0.13),
        # 30 Hz: silence is declared after three periods.
        ([(0.1, SILENT), (0.001, BLAMED), (0.05, BLAMED)], 0.151),
        # A stuck axis is reported with every sample.
        ([(0.01, faults.invalid(WRENCH, "stuck"))] * 15, 0.13),
    ],
)
def test_counts_from_the_last_healthy_wrench_through_every_fault_of_it(
    calls: list[tuple[float, Fault]], time: float
) -> None:
    assert latched_after(*calls) == pytest.approx(time)


@pytest.mark.parametrize(
    "calls",
    [
        # A healthy wrench, a missing robot or a stall of the own loop (with healthy inputs) begins the count anew.
        [(0.03, BLAMED), (0.05, BLAMED), (0.01, None), (0.03, BLAMED), (0.05, BLAMED)],
        [(0.03, BLAMED), (0.05, BLAMED), (0.05, NO_ROBOT), (0.03, BLAMED), (0.05, BLAMED)],
        [(0.03, BLAMED), (0.05, BLAMED), (0.05, faults.arming(0.5)), (0.03, BLAMED), (0.05, BLAMED)],
        # A robot that is gone altogether: its pose is allowed to be older than its force.
        [(0.03, BLAMED), (0.05, BLAMED), (0.03, BLAMED), (0.001, NO_ROBOT), (0.05, NO_ROBOT)],
        # Nobody blames the sensor, or only a process that was asleep itself.
        [(0.05, SILENT)] * 100,
        [(0.05, faults.invalid(WRENCH, "invalid"))] * 100,
        [*[(0.05, SILENT)] * 100, (0.05, BLAMED), (0.01, None)],
        [(0.1, BLAMED), (0.01, None)],
    ],
)
def test_latches_nothing_else(calls: list[tuple[float, Fault | None]]) -> None:
    assert latched_after(*calls) is None


def test_says_what_and_how_to_release_until_released() -> None:
    latch = SensorLatch()
    for _ in range(3):
        latch.fault(faults.invalid(WRENCH, "saturated"), 0.05)
    latch.healthy()
    assert "saturated for more than 100 ms" in latch.reason and "tandem resume" in latch.reason
    latch.release()
    assert latch.reason == ""


def heard(engaged: bool, reason: str = "", valid: bool = True, new: bool = True) -> Inputs:
    return Inputs({STOP.key: Reading(Stop(engaged, reason), Header(0, 1, 0, valid), 0.0, new)})


def fail_sensor(halt: Halt) -> None:
    for _ in range(4):
        halt.fault(faults.invalid(WRENCH_EXTERNAL.key, "stuck"), 0.05)


def test_nothing_halts_at_first() -> None:
    halt = Halt()
    halt.listen(Inputs())
    assert halt.reason == halt.latched == ""


def test_a_stop_halts_whatever_its_publisher_thinks_of_itself_until_a_valid_release() -> None:
    halt = Halt()
    halt.listen(heard(True, "red button", valid=False))
    assert halt.reason == "stop is engaged: red button" and halt.latched == ""
    halt.listen(heard(False, valid=False))
    assert halt.reason
    halt.listen(heard(False, new=False))
    assert halt.reason
    halt.listen(heard(False))
    assert halt.reason == ""
    halt.listen(heard(True))
    assert halt.reason == "stop is engaged: no reason given"


def test_a_latched_sensor_halts_through_healthy_steps_until_a_release() -> None:
    halt = Halt()
    fail_sensor(halt)
    halt.listen(Inputs())
    assert halt.reason == halt.latched and "tandem resume" in halt.latched
    halt.listen(heard(True, "red button"))
    assert "stuck" in halt.reason, "the sensor is the more lasting one"
    halt.listen(heard(False))
    assert halt.reason == ""
