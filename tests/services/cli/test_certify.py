"""`tandem certify` of a running controller says what it says offline for the same parameters, to the last digit."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from services.cli.certify import LIMIT, parameters_of, running
from services.controller.parameters import ControllerParameters
from shared.loop.config import service_parameters
from shared.messages import ControlStatus, ControlTarget, ExternalWrench, Header, TaskStatus
from shared.schema.records import Record
from shared.wire.codec import decode_map, encode_map
from shared.wire.subscription import Received
from tests.conftest import Router, StartProcess
from tests.services.cli.command import tandem_here
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
max_retreat_acceleration = [2.1, 2.2, 2.3, 2.4, 2.5, 2.6123456789]

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


def test_a_reply_holds_every_parameter_to_the_last_digit(config: Path) -> None:
    chosen = service_parameters("controller", ControllerParameters, config, [])
    default = ControllerParameters()
    for name in ControllerParameters.model_fields:
        assert getattr(chosen, name) != getattr(default, name), f"{name} is not tested"
    assert parameters_of(decode_map(encode_map(chosen.table()))) == chosen


def test_the_table_names_what_limits(capsys: pytest.CaptureFixture[str]) -> None:
    done = tandem_here(capsys, "certify", "--offline", "--torque-limit", "0.5,3,3", "--torque-error", "0.03")
    assert done.returncode == 0
    for words in ("limit about x", "mm/s", "excess", "strict"):
        assert words in done.stdout


def test_file_and_settings_are_certified_as_json(capsys: pytest.CaptureFixture[str], config: Path) -> None:
    done = tandem_here(capsys, "certify", "--config", str(config), "--set", "contact_stiffness=300.0", "--json")
    found = json.loads(done.stdout)
    assert found["form"].startswith("rounded") and len(found["axes"]) == 6
    assert all(one["speed"] > 0 for one in found["axes"])


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (["--force-limit", "-3"], ("--force-limit", "-3")),
        (["--force-limit", "1,2"], ("--force-limit", "1,2")),
        (["--force-limit", "x"], ("--force-limit",)),
        (["--force-error", "20"], ("25 N x", "20")),
        (["--set", "period=3.0"], ("period", "0.2")),
        (["--bogus"], ("--bogus",)),
        *((["--orientation", text, "--json"], ("wanted a unit quaternion",)) for text in ("0,0,0,0", "0,0,1", "x")),
    ],
)
def test_refusals_are_one_line_with_status_2(
    arguments: list[str], parts: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    done = tandem_here(capsys, "certify", "--offline", *arguments)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert all(part in line for part in parts), line


def heard(message: Record, session: int, age: float, valid: bool = True) -> Received:
    return Received(1, Header(1, session, 0, valid), message, round(-age * 1e9), 0.0)


SIX, STILL = (0.0,) * 6, ((0.0,) * 3, (0.0, 0.0, 0.0, 1.0))
STATUS = ControlStatus("yielding", "", "certified", SIX, SIX, SIX, 0.0, 0.0, 0.0, limit=(9.0,) * 6, nominal=SIX)
TARGET = heard(ControlTarget(*STILL, (5.0,) * 3, (1.0,) * 3), 7, 0.1)
WRENCH = ExternalWrench(SIX[:3], SIX[:3], (0.5,) * 6, "tare", "stuck", zero_age=90.0)


def test_of_a_running_system_the_limits_in_force_count_and_whose_they_are_is_said() -> None:
    task = heard(TaskStatus("carrying", 0.0, "", 0.0, 0.0, None), 7, 0.2)
    found = running(
        ControllerParameters(), heard(STATUS, 1, 0.25), heard(WRENCH, 2, 3.0, False), TARGET, task, now_ns=0
    )
    assert np.array_equal(found.limit, [9.0] * 6) and np.array_equal(found.error_bound, [0.5] * 6)
    for words in ("(yielding), 0.2 s old", "target by task", "3.0 s old, zero 90 s old", "not valid (stuck)"):
        assert words in found.said
    other = running(ControllerParameters(law="paper"), heard(STATUS, 1, 0.2), None, TARGET, None, now_ns=0)
    assert "target by another program" in other.said and "law paper, which promises none of this" in other.said
    assert "0.1 Nm assumed, no wrench is heard" in other.said


def test_without_a_target_limits_are_assumed_and_that_is_said() -> None:
    waiting = ControlStatus("waiting", "", "certified", SIX, SIX, SIX, 0.0, 0.0, 0.0, limit=SIX, nominal=SIX)
    found = running(ControllerParameters(), heard(waiting, 1, 0.1), None, None, None, now_ns=0)
    assert found.limit.tolist() == list(LIMIT) and "25 N, 10 Nm assumed, no target is in force" in found.said


@pytest.mark.processes
@pytest.mark.timeout(180)
def test_a_running_controller_is_certified_as_offline(
    config: Path, shared_router: Router, start: StartProcess, capsys: pytest.CaptureFixture[str]
) -> None:
    connect = ("--connect", shared_router.endpoint)
    start("services.controller", "--config", str(config), *connect)

    def running() -> str | None:
        done = tandem_here(capsys, "certify", *connect, "--json")
        return done.stdout if "for the controller that runs" in done.stderr else None

    printed = eventually(running, 120.0, "the controller answers")
    offline = tandem_here(capsys, "certify", "--offline", "--config", str(config), "--json").stdout
    assert json.loads(printed) == json.loads(offline)
    bare = tandem_here(capsys, "certify", "--offline", "--json").stdout
    assert json.loads(bare)["axes"][0]["speed"] > 10 * json.loads(offline)["axes"][0]["speed"]
