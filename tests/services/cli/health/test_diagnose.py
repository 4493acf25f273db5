"""A service is alive, lost or never seen; whatever is wrong comes with a remedy."""

from __future__ import annotations

import pytest

from services.cli.health.diagnose import Heard, control_line, never_seen, one_robot, robot_line, rows, task_line
from shared.messages import ControlStatus, Health, RobotStatus, TaskStatus
from shared.processes import STACK


def health(state: str = "ok", detail: str = "") -> Health:
    return Health(state, detail, 100.0, 100.0, 200.0, 0, {})


@pytest.mark.parametrize(
    ("living", "age", "message", "state", "ok"),
    [
        (True, 0.3, health(), "ok", True),
        (True, 0.3, health("starting", "waiting for sensor/ft"), "starting", True),
        (True, 0.3, health("degraded", "sensor/ft is silent"), "degraded", False),
        (True, 1.4, health(), "lost", False),
        (False, 0.3, health(), "lost", False),
        (False, None, None, "lost", False),
        (True, None, None, "silent", False),
    ],
    ids=["ok", "starting", "degraded", "hung", "killed", "killed before it spoke", "mute"],
)
def test_state_of_a_service(living: bool, age: float | None, message: Health | None, state: str, ok: bool) -> None:
    heard = {} if message is None or age is None else {"controller": Heard(message, age)}
    row = rows({"controller"} if living else set(), heard, ["controller"])[0]
    assert (row.service, row.state, row.ok) == ("controller", state, ok)
    if state in ("lost", "silent"):
        assert "tandem start controller" in row.detail
    elif message is not None:
        assert row.detail == message.detail


def test_expected_services_come_first_and_others_are_not_hidden() -> None:
    found = rows({"base", "sim"}, {"base": Heard(health(), 0.1)}, ["sim", "wrench"])
    assert [row.service for row in found] == ["sim", "wrench", "base"]


def test_a_service_that_was_never_started_is_not_called_lost() -> None:
    assert never_seen("wrench").state == "never seen"
    assert "tandem start wrench" in never_seen("wrench").detail


def test_whichever_robot_runs_no_other_one_is_missed() -> None:
    real = RobotStatus("ready", "", "omni", False, 0.25, 0.5, (0.0, 0.0, 0.0))
    assert "sim" in one_robot(STACK, {"wrench"}, None), "none runs: the usual one is missed"
    assert "sim" in one_robot(STACK, {"sim", "mock"}, None), "two are both shown"
    assert set(STACK) - set(one_robot(STACK, {"mock", "wrench"}, None)) == {"sim"}
    assert set(STACK) - set(one_robot(STACK, {"robot", "wrench"}, real)) == {"sim"}
    assert set(STACK) - set(one_robot(STACK, {"wrench"}, real)) == {"sim"}, "a robot without a token"


@pytest.mark.parametrize(
    ("name", "remedy"),
    [
        ("base", "tandem start base"),
        ("sim", "tandem start sim"),
        ("mock", "python -m services.mock"),
        ("robot", "no process of this project"),
        ("nobody", "no process of this project"),
    ],
)
def test_the_remedy_follows_from_what_the_process_is(name: str, remedy: str) -> None:
    assert remedy in rows(set(), {}, [name])[0].detail


def test_a_stopped_robot_names_the_remedy() -> None:
    status = RobotStatus("stopped", "tandem stop", "omni", True, 0.25, 0.5, (0.0, 0.0, 0.0))
    line, ok = robot_line(status)
    assert not ok
    assert "tandem resume" in line
    assert robot_line(None)[1] is False


def test_a_braking_controller_gives_its_reason() -> None:
    zero = (0.0,) * 6
    status = ControlStatus("braking", "wrench/external is silent", "paper", zero, zero, zero, 0.0, 0.0, 0.0)
    line, ok = control_line(status)
    assert not ok
    assert "wrench/external is silent" in line


@pytest.mark.parametrize(("state", "ok"), [("carrying", True), ("holding", False)])
def test_a_task_that_waits_for_a_person_is_wrong_and_gives_its_reason(state: str, ok: bool) -> None:
    line, found = task_line(TaskStatus(state, 1.0, "the marker was lost", 0.0, 0.8, None))
    assert found == ok and line == f"{state}: the marker was lost"
