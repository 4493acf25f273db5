"""What every robot process does with commands and stops, and how often it tells of it."""

from __future__ import annotations

import pytest

from shared.messages import BaseTwistCommand, Header, Stop, TwistCommand
from shared.robot.gate import SILENCE
from shared.robot.side import HOLDING_AFTER
from shared.service import Inputs, Reading
from shared.topics import COMMAND_BASE_TWIST, COMMAND_EE_TWIST, STOP
from tests.shared.robot.rig import FORWARDS, ZERO, Process


@pytest.fixture
def process() -> Process:
    return Process()


def test_the_first_tick_tells_who_it_is(process: Process) -> None:
    process.tick()
    (status,) = process.statuses
    assert (status.mode, status.base_type, status.simulated) == ("holding", "omni", False)
    assert (status.max_linear, status.max_angular, *status.max_base) == (0.3, 1.0, 0.5, 0.4, 0.3)
    assert status.reason == "no fresh command; the arm is short"


def test_a_command_is_taken_once(process: Process) -> None:
    process.send(COMMAND_EE_TWIST, TwistCommand((1.0, 0.0, 0.0), ZERO, 0.05))
    moved = [bool(process.tick().any()) for _ in range(10)]
    assert moved == [True] * 5 + [False] * 5
    assert process.side.gate.clamped == 1


def test_a_command_acts_from_the_step_on_in_which_it_arrived(process: Process) -> None:
    reading = Reading(TwistCommand(FORWARDS, ZERO, 0.01), Header(0, 1, 0, True), 0.005, True)
    process.side.take(Inputs({COMMAND_EE_TWIST.key: reading}), behind=0.01)
    assert [bool(process.side.advance(0.001).any()) for _ in range(10)] == [False] * 5 + [True] * 5
    process.side.take(Inputs(), behind=0.01)
    assert [bool(process.side.advance(0.001).any()) for _ in range(10)] == [True] * 5 + [False] * 5


@pytest.mark.parametrize("valid", [True, False])
def test_a_stop_engages_whatever_its_publisher_thinks_of_itself(process: Process, valid: bool) -> None:
    process.move(ttl=0.2)
    assert process.tick().any()
    process.send(STOP, Stop(True, "hand on the button"), valid)
    assert not process.tick().any()
    assert process.statuses[-1].mode == "stopped"
    assert "hand on the button" in process.statuses[-1].reason


def test_only_a_valid_message_releases_a_stop(process: Process) -> None:
    process.send(STOP, Stop(True, "hand on the button"))
    process.tick()
    process.send(STOP, Stop(False, ""), valid=False)
    process.move()
    assert not process.tick().any()
    assert process.side.mode == "stopped"
    process.send(STOP, Stop(False, ""))
    process.move()
    assert process.tick().any()
    assert process.statuses[-1].mode == "ready"


def test_at_rest_it_tells_five_times_a_second(process: Process) -> None:
    process.run(4.0)
    assert len(process.statuses) == pytest.approx(20, abs=1)


def test_commands_at_30_hz_that_last_20_ms_change_the_mode_once(process: Process) -> None:
    for _ in range(60):
        process.move(ttl=0.02)
        process.run(0.03)
    assert len(process.statuses) <= 1.8 / HOLDING_AFTER + 1
    assert all(status.mode == "ready" for status in process.statuses)
    assert process.statuses[-1].reason == "the arm is short"
    count = len(process.statuses)
    process.run(max(HOLDING_AFTER, SILENCE) + 0.02)
    assert [status.mode for status in process.statuses[count:]].count("holding") == 1
    process.run(0.2)
    assert process.statuses[-1].reason == "no fresh command; the arm is short; commands expired: 1"


def test_a_motion_that_was_broken_off_shortly_is_told_soon(process: Process) -> None:
    process.move(ttl=0.2)
    process.run(0.1)
    process.move(ttl=0.02)
    process.run(0.03)
    process.move(ttl=1.0)
    process.run(HOLDING_AFTER)
    assert [status.held for status in process.statuses] == [0, 1]
    assert process.statuses[-1].mode == "ready"


def test_what_was_not_executed_as_sent_is_counted_in_words(process: Process) -> None:
    process.move(ttl=0.02, age=0.05)
    assert not process.tick().any()
    process.side.report(1.0)
    refusals = {COMMAND_EE_TWIST.key: "3 rejected", STOP.key: "1 out of sequence"}
    for _ in range(20):
        process.tick(refusals)
    reason = process.statuses[-1].reason
    assert "commands late: 1" in reason and "expired" not in reason
    assert "command/ee_twist: 3 rejected; stop: 1 out of sequence" in reason


def test_a_process_that_does_not_work_executes_nothing_until_the_next_command(process: Process) -> None:
    process.move(ttl=0.2)
    assert process.tick().any()
    (output,) = process.side.hold("the arm does not answer")
    assert (output.message.mode, output.message.reason) == ("holding", "the arm does not answer")
    assert not process.tick().any()
    process.move()
    assert process.tick().any()


def test_a_process_that_does_not_work_keeps_its_stop(process: Process) -> None:
    process.send(STOP, Stop(True, "hand on the button"))
    process.tick()
    (output,) = process.side.hold("the arm does not answer")
    assert output.message.mode == "stopped"
    process.move()
    assert not process.tick().any()


def test_the_limit_is_told_that_the_base_was_held_to(process: Process) -> None:
    process.send(COMMAND_BASE_TWIST, BaseTwistCommand((-0.5, 0.0, 0.0)))
    process.tick()
    process.side.advance_base(0.01)
    process.run(0.3)
    assert "base commands clamped: 1 (last: backwards over 0.2 m/s)" in process.statuses[-1].reason
