"""The compose file and the images agree with the table of processes, and nobody has more than it needs."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
import yaml

from shared.processes import CLI, EXPERIMENT, PROCESSES, Process, process_named

ROOT = Path(__file__).parents[2]
DOCKERFILE = (ROOT / "deploy" / "Dockerfile").read_text(encoding="utf-8")
COMPOSE = yaml.safe_load((ROOT / "docker-compose.yml").read_text(encoding="utf-8"))
REALTIME = yaml.safe_load((ROOT / "deploy" / "compose.realtime.yml").read_text(encoding="utf-8"))
SERVICES: dict[str, dict[str, Any]] = COMPOSE["services"]
OPERATOR = "tandem"
BY_ITSELF = [process.name for process in PROCESSES if process.started != "by hand"]

every_service = pytest.mark.parametrize("name", SERVICES)
every_process = pytest.mark.parametrize("process", PROCESSES, ids=lambda process: process.name)


def process_of(name: str) -> Process:
    return CLI if name == OPERATOR else process_named(name)


def test_every_process_of_the_carry_has_a_container() -> None:
    assert set(SERVICES) == {*BY_ITSELF, EXPERIMENT.name, OPERATOR}


@every_service
def test_it_runs_its_module_in_its_image_as_its_user(name: str) -> None:
    service, process = SERVICES[name], process_of(name)
    assert service["build"]["target"] == process.image
    assert service["image"] == f"tandem-{process.image}"
    command = [*service.get("entrypoint", []), *service.get("command", [])]
    assert command[command.index("python") :][:3] == ["python", "-m", process.module]
    assert service["user"] == ("root" if process is EXPERIMENT else process.name)


@every_service
def test_it_may_do_nothing_but_its_work(name: str) -> None:
    service = SERVICES[name]
    assert service["read_only"]
    # An init in front of a service would be what `kill -s STOP` hangs.
    assert ("init" in service) == (name not in BY_ITSELF)
    assert service["cap_drop"] == ["ALL"]
    # The experiment becomes the owner of the folder that it writes into, and cannot come back.
    assert service.get("cap_add", []) == (["SETUID", "SETGID"] if name == EXPERIMENT.name else [])
    assert service["security_opt"] == ["no-new-privileges"]
    assert service["mem_limit"] and service["pids_limit"]
    assert service["stop_grace_period"] == "2s"
    assert service["networks"] == ["bus"] and "ports" not in service
    assert not {"privileged", "devices", "pid", "ipc", "network_mode"} & service.keys()
    own = {f"{name}:/home/{name}", "./runs:/opt/tandem/runs"} if name == EXPERIMENT.name else {f"{name}:/home/{name}"}
    assert set(service.get("volumes", [])) <= own


@pytest.mark.parametrize("name", BY_ITSELF)
def test_it_is_asked_how_it_is_and_restarted(name: str) -> None:
    service = SERVICES[name]
    assert service["healthcheck"]["test"][-3:] == ["-m", "shared.loop.healthy", name]
    assert service["restart"] == "unless-stopped"


def test_nothing_is_reached_from_outside_and_old_and_new_compose_read_it() -> None:
    assert COMPOSE["networks"] == {"bus": {"internal": True}}
    for file in (COMPOSE, REALTIME):
        assert not {"version", "name", "include"} & file.keys()
    assert set(REALTIME["services"]) <= set(SERVICES)


@every_process
def test_its_image_has_its_user_and_all_that_it_needs(process: Process) -> None:
    assert re.search(rf"^FROM \w+ AS {process.image}$", DOCKERFILE, re.MULTILINE)
    users = re.search(r"^RUN for name in ([\w ]+); do", DOCKERFILE, re.MULTILINE)
    assert users is not None and process.name in users[1].split()
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    needed = [*project["dependencies"], *(project["optional-dependencies"].get(process.extra, []))]
    pins, tested = (pinned(name) for name in (process.image, "all"))
    for requirement in needed:
        package = re.split(r"[\[=<>]", requirement)[0]
        assert pins[package] == tested[package], "what is tested is what is deployed: make lock"


def pinned(name: str) -> dict[str, str]:
    """Package -> version of a file of requirements."""
    text = (ROOT / "deploy" / "requirements" / f"{name}.txt").read_text(encoding="utf-8")
    return dict(re.findall(r"^([\w.-]+)==(\S+)", text, re.MULTILINE))


def test_no_step_needs_a_newer_builder() -> None:
    assert not re.search(r"--mount|--link|<<|^# *syntax", DOCKERFILE, re.MULTILINE)
