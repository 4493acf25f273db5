"""CPU and memory of the processes of one robot, found among all that run on the machine."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from services.cli.health.usage import UsageMeter, module_of, of
from tests.conftest import Router, StartProcess
from tests.support.wait import eventually

HERE = ("tiago", "tcp/127.0.0.1:7447")


@pytest.mark.parametrize(
    ("command", "environment", "name", "whose"),
    [
        ("python -m services.wrench --robot tiago --connect tcp/h:1", {}, "wrench", ("tiago", "tcp/h:1")),
        ("python -m services.wrench", {}, "wrench", HERE),
        ("python -m services.task", {"TANDEM_ROBOT": "reem", "TANDEM_CONNECT": "tcp/h:2"}, "task", ("reem", "tcp/h:2")),
        ("python -m services.task --robot tiago", {"TANDEM_ROBOT": "reem"}, "task", HERE),
        ("python -m services.router --listen tcp/h:3", {}, "router", ("", "tcp/h:3")),
    ],
)
def test_whose_a_process_is(command: str, environment: dict[str, str], name: str, whose: tuple[str, str]) -> None:
    assert module_of(command.split()) == name
    assert of(name, command.split(), environment) == whose


@pytest.mark.parametrize("command", ["python -m pytest", "vi services.wrench", "python -m services.cli top", ""])
def test_who_is_none_of_the_processes(command: str) -> None:
    assert module_of(command.split()) == ""


@pytest.mark.processes
def test_processes_are_found_with_what_they_use(router: Router, start: StartProcess) -> None:
    wrench = start("services.wrench", "--connect", router.endpoint)
    start("services.wrench", "--connect", router.endpoint, "--robot", "other")
    meter = UsageMeter("tiago", router.endpoint)
    eventually(lambda: meter.look().keys() == {"router", "wrench"}, message="both are found")
    used = meter.look()
    assert used["wrench"].pid == wrench.pid and used["router"].pid == router.process.pid
    pages = int(Path(f"/proc/{wrench.pid}/statm").read_text().split()[1])
    assert used["wrench"].memory == pytest.approx(pages * os.sysconf("SC_PAGE_SIZE") / 1e6, rel=0.5)
    # Health twice a second takes its time, if little.
    eventually(lambda: meter.look()["wrench"].cpu > 0.0, 60.0, "it has worked between two looks")
