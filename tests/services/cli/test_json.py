"""What `--json` prints is one document that a strict reader takes, with the units of its numbers."""

from __future__ import annotations

import json
from typing import Any, NoReturn

import pytest

from shared.topics import CONTROL_STATUS
from tests.conftest import Router, StartProcess
from tests.services.cli.command import tandem_here
from tests.services.cli.test_second import ROBOT
from tests.support.stand_in import StandIn
from tests.support.wait import eventually

pytestmark = pytest.mark.processes


def strict(text: str) -> Any:
    def refuse(constant: str) -> NoReturn:
        raise ValueError(f"{constant} is no JSON")

    return json.loads(text, parse_constant=refuse)


def test_state_and_rates_of_a_stack(shared_router: Router, capsys: pytest.CaptureFixture[str]) -> None:
    place = ("--connect", shared_router.endpoint, "--json")
    with StandIn(shared_router.endpoint, "controller", lambda number: ROBOT) as controller:
        eventually(lambda: controller.turns > 10)
        done = tandem_here(capsys, "status", *place)
        found = strict(done.stdout)
        assert done.returncode == 1 and not found["good"]
        assert any("tandem start wrench" in reason for reason in found["wrong"])
        states = {row["service"]: row["state"] for row in found["services"]}
        assert states["wrench"] == "never seen"
        assert found["controller"]["state"] == "tracking" and found["units"]["controller"]["margin"] == "N, Nm"
        assert found["gate"]["max_linear"] == 0.3 and found["units"]["gate"]["max_linear"] == "m/s"
        assert found["load"] is None and found["rates_hz"]["sensor/ft"] == 0.0
        rates = strict(tandem_here(capsys, "topic", "hz", "--seconds", "0.5", *place).stdout)
        told = {row["key"]: row for row in rates["topics"]}
        assert told[CONTROL_STATUS.key]["measured_hz"] > 0.0 and told[CONTROL_STATUS.key]["age_ms"] >= 0
        both = tandem_here(capsys, "topic", "hz", "--watch", *place)
        assert both.returncode == 2 and "--watch and --json: choose one" in both.stderr


def test_parameters_are_told_with_their_units(
    shared_router: Router, start: StartProcess, capsys: pytest.CaptureFixture[str]
) -> None:
    place = ("--connect", shared_router.endpoint, "--json")
    start("services.wrench", "--connect", shared_router.endpoint)
    changed = eventually(
        lambda: tandem_here(capsys, "param", "set", "wrench.lowpass_hz=5", *place).stdout, 60.0, "it answers"
    )
    row = strict(changed)["changed"]["wrench"]["lowpass_hz"]
    assert row | {"doc": ""} == {"value": 5.0, "unit": "Hz", "min": 0.0, "max": 1000.0, "doc": ""}
    one = strict(tandem_here(capsys, "param", "get", "wrench.lowpass_hz", *place).stdout)["parameters"]
    assert one == {"lowpass_hz": row}
    every = strict(tandem_here(capsys, "param", "get", "wrench", *place).stdout)
    assert every["service"] == "wrench" and set(one) < set(every["parameters"])


def test_a_certificate_names_the_units_of_its_numbers(capsys: pytest.CaptureFixture[str]) -> None:
    found = strict(tandem_here(capsys, "certify", "--offline", "--json").stdout)
    for name in found["units"]:
        outer, _, inner = name.partition(".")
        inside = found[outer][0] if outer == "axes" else found[outer]
        assert not inner or inner in inside
