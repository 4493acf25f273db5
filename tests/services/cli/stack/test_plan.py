"""What makes a stack, and what of it is remembered."""

from __future__ import annotations

from pathlib import Path

import pytest

from services.cli.stack.plan import Plan, parse_settings, remembered
from shared.processes import FURTHER, STACK

ENDPOINT = "tcp/127.0.0.1:7001"


def test_further_services_are_part_of_a_stack_only_if_asked_for() -> None:
    assert Plan("tiago", ENDPOINT).services == STACK
    assert Plan("tiago", ENDPOINT, further=FURTHER).services == (*STACK, "base", "task")


def test_every_service_can_be_started_whether_or_not_it_is_part_of_the_stack() -> None:
    plan = Plan("tiago", ENDPOINT, settings=parse_settings(["base.mass=20", "wrench.lowpass_hz=5"]))
    expected = ["--robot", "tiago", "--connect", ENDPOINT, "--links", "sockets", "--set", "mass=20"]
    assert plan.arguments("base") == expected
    with pytest.raises(KeyError):
        plan.arguments("nobody")


@pytest.mark.parametrize(
    ("endpoint", "chosen", "links"),
    [
        (ENDPOINT, None, "sockets"),
        ("tcp/0.0.0.0:7001", None, "none"),
        (ENDPOINT, "none", "none"),
        (ENDPOINT, "tcp/{name}:1", "tcp/{name}:1"),
    ],
)
def test_a_stack_on_one_machine_has_direct_links_unless_told_otherwise(
    endpoint: str, chosen: str | None, links: str
) -> None:
    plan = Plan("tiago", endpoint, links=chosen)
    for name in ("sim", "wrench", "controller", "base", "task"):
        arguments = plan.arguments(name)
        assert arguments[arguments.index("--links") + 1] == links
    assert "--links" not in plan.arguments("router")


def test_a_plan_is_remembered_until_it_is_forgotten(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    plan = Plan("tiago", ENDPOINT, tmp_path / "c.toml", {"base": ["mass=20"]}, ("base",), "none")
    plan.remember()
    assert remembered("tiago", ENDPOINT) == plan
    assert remembered("other", ENDPOINT) is None
    plan.forget()
    assert remembered("tiago", ENDPOINT) is None


def test_another_process_stands_for_the_robot(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    plan = Plan("tiago", ENDPOINT, robot_process="mock")
    assert plan.services == ("mock", *STACK[1:]) and plan.expected == plan.services
    real = Plan("tiago", ENDPOINT, robot_process="bridge_ros1")
    assert real.expected == ("robot", *STACK[1:])
    real.remember()
    assert remembered("tiago", ENDPOINT) == real
    real.forget()
    assert parse_settings(['bridge_ros1.profile="mine.toml"']) == {"bridge_ros1": ['profile="mine.toml"']}
