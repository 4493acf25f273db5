"""The compose file and the images agree with the table of processes, and nobody has more than it needs."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
import yaml

from shared.loop import healthy
from shared.processes import CLI, EXPERIMENT, PROCESSES, Process, process_named
from shared.wire import access

ROOT = Path(__file__).parents[2]
DOCKERFILE = (ROOT / "deploy" / "Dockerfile").read_text(encoding="utf-8")
COMPOSE = yaml.safe_load((ROOT / "docker-compose.yml").read_text(encoding="utf-8"))
REALTIME = yaml.safe_load((ROOT / "deploy" / "compose.realtime.yml").read_text(encoding="utf-8"))
SERVICES: dict[str, dict[str, Any]] = COMPOSE["services"]
OPERATOR, KEYS = "tandem", "keys"
"""Containers of the command line: the person's, and the one that makes everybody's keys before the others start."""
BY_ITSELF = [process.name for process in PROCESSES if process.started != "by hand"]

CAPABILITIES = {
    # It becomes the owner of the folder that it writes into, and cannot come back.
    EXPERIMENT.name: ["SETUID", "SETGID"],
    # It writes into everybody's volume, and gives what it wrote to whose it is.
    KEYS: ["CHOWN", "DAC_OVERRIDE"],
}
"""Of whoever has any, and starts as root for them."""

every_service = pytest.mark.parametrize("name", SERVICES)
every_process = pytest.mark.parametrize("process", PROCESSES, ids=lambda process: process.name)


def process_of(name: str) -> Process:
    return CLI if name in (OPERATOR, KEYS) else process_named(name)


def participant(name: str) -> str:
    """Whose certificate a container has."""
    return access.OPERATOR if name == OPERATOR else name


CLOSED = [name for name in SERVICES if name != KEYS]


def test_every_process_of_the_carry_has_a_container() -> None:
    assert set(SERVICES) == {*BY_ITSELF, EXPERIMENT.name, OPERATOR, KEYS}


@every_service
def test_it_runs_its_module_in_its_image_as_its_user(name: str) -> None:
    service, process = SERVICES[name], process_of(name)
    assert service["build"]["target"] == process.image
    assert service["image"] == f"tandem-{process.image}"
    command = [*service.get("entrypoint", []), *service.get("command", [])]
    assert command[command.index("python") :][:3] == ["python", "-m", process.module]
    assert service["user"] == ("root" if name in CAPABILITIES else process.name)


@every_service
def test_it_may_do_nothing_but_its_work(name: str) -> None:
    service = SERVICES[name]
    assert service["read_only"]
    # An init in front of a service would be what `kill -s STOP` hangs; one of root's cannot signal another user.
    assert ("init" in service) == (name in (OPERATOR, KEYS))
    assert service["cap_drop"] == ["ALL"]
    assert service.get("cap_add", []) == CAPABILITIES.get(name, [])
    assert service["security_opt"] == ["no-new-privileges"]
    assert service["mem_limit"] and service["pids_limit"]
    assert service["stop_grace_period"] == "2s"
    assert (service.get("networks"), service.get("network_mode")) == (
        (None, "none") if name == KEYS else (["bus"], None)
    )
    assert not {"ports", "privileged", "devices", "pid", "ipc"} & service.keys()
    own = {f"{name}:/home/{name}", *(["./runs:/opt/tandem/runs"] if name == EXPERIMENT.name else [])}
    assert {volume for volume in service.get("volumes", []) if "/keys/" not in volume} <= own


@pytest.mark.parametrize("name", CLOSED)
def test_it_has_a_certificate_of_its_own_and_waits_for_it(name: str) -> None:
    service, own = SERVICES[name], participant(name)
    assert [volume for volume in service["volumes"] if "/keys/" in volume] == [f"keys-{own}:/keys/{own}:ro"]
    assert service["environment"]["TANDEM_SECURE"] == f"/keys/{own}"
    port = SERVICES["router"]["environment"]["TANDEM_LISTEN"].rpartition(":")[2]
    assert name == "router" or service["environment"]["TANDEM_CONNECT"] == f"tls/router:{port}"
    # The person's command does not make keys each time; it needs a stack that runs anyway.
    assert name == OPERATOR or service["depends_on"]["keys"] == {"condition": "service_completed_successfully"}


def test_the_keys_are_made_for_everybody_and_the_authority_s_goes_to_nobody() -> None:
    made = SERVICES[KEYS]
    owners = {participant(name): SERVICES[name]["user"] for name in CLOSED}
    assert made["environment"]["TANDEM_KEYS"].split() == [*owners]
    assert made["volumes"] == [f"keys-{owner}:/keys/{owner}" for owner in ("authority", *owners)]
    assert {f"keys-{owner}" for owner in ("authority", *owners)} <= set(COMPOSE["volumes"])
    # An empty volume takes owner and mode of the image's directory.
    directories = re.search(r"^RUN for keys in ([^;]+); do", DOCKERFILE, re.MULTILINE)
    assert directories is not None
    assert dict(re.findall(r"(\w+)=(\w+)", directories[1])) == {"authority": "root", **owners}


@pytest.mark.parametrize("name", BY_ITSELF)
def test_it_is_asked_how_it_is_and_restarted(name: str) -> None:
    service = SERVICES[name]
    assert service["healthcheck"]["test"][-1] == str(Path(healthy.__file__).relative_to(ROOT))
    assert service["tmpfs"] == ["/tmp"] and "TANDEM_HEALTH=/tmp/" in DOCKERFILE
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
