"""`tandem certify` of a running controller says what it says offline for the same parameters, to the last digit."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from services.cli.certify import assignments
from services.controller.parameters import ControllerParameters
from shared.loop.config import service_parameters
from tests.conftest import Router, StartProcess
from tests.services.cli.command import tandem
from tests.support.wait import eventually

CONFIG = """
[controller]
law = "paper"
lyapunov_rate = 7.123456789
relaxation_weight = 0.333333333333
barrier_rate = [1.5, 2.5, 3.5, 4.5, 5.5, 6.123456789]
contact_stiffness = 412.3456789
contact_reach = [0.9, 0.2, 0.0123456789]
contact_friction = 0.31
reserve = 0.15
yield_start = 0.81234567
period = 0.0123456789
delay = 0.0312345678
lag = 0.0412345678
payload_mass = 0.0512345678
spring_stiffness = [41.0, 42.0, 43.0, 11.0, 12.0, 13.0]
max_linear = 0.8912345678
max_angular = 1.912345678
max_acceleration = [1.1, 1.2, 1.3, 1.4, 1.5, 1.6123456789]

[[controller.zones]]
stiffness = 1e5
reach = [0.0123456789, 0.1, 0.05]
friction = 0.2

[[controller.zones]]
stiffness = 2345.678901
reach = [0.1, 0.1, 0.05]
"""


@pytest.fixture
def config(tmp_path: Path) -> Path:
    path = tmp_path / "controller.toml"
    path.write_text(CONFIG)
    return path


def test_assignments_restore_every_parameter(config: Path) -> None:
    chosen = service_parameters("controller", ControllerParameters, config, [])
    default = ControllerParameters()
    for name in ControllerParameters.model_fields:
        assert getattr(chosen, name) != getattr(default, name), f"{name} is not tested"
    assert service_parameters("controller", ControllerParameters, None, assignments(chosen.table())) == chosen


@pytest.mark.processes
@pytest.mark.timeout(180)
def test_a_running_controller_is_certified_as_offline(
    config: Path, shared_router: Router, start: StartProcess
) -> None:
    connect = ("--connect", shared_router.endpoint)
    start("services.controller", "--config", str(config), *connect)

    def running() -> str | None:
        done = tandem("certify", *connect, "--json")
        return done.stdout if "for the controller that runs" in done.stderr else None

    printed = eventually(running, 120.0, "the controller answers")
    offline = tandem("certify", "--offline", "--config", str(config), "--json").stdout
    assert json.loads(printed) == json.loads(offline)
    bare = tandem("certify", "--offline", "--json").stdout
    assert json.loads(bare)["axes"][0]["speed"] > 10 * json.loads(offline)["axes"][0]["speed"]
