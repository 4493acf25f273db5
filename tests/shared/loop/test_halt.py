"""Stops and latched sensor failures keep a service at rest until a valid release."""

from __future__ import annotations

from shared import faults
from shared.loop.halt import Halt
from shared.messages import Header, Stop
from shared.service import Inputs, Reading
from shared.topics import STOP, WRENCH_EXTERNAL


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
