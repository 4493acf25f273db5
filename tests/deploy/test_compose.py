"""The compose file and the images agree with the table of processes, and nobody has more than it needs."""

from __future__ import annotations

import re
import shlex
import tomllib
from pathlib import Path
from typing import Any

import pytest
import yaml

from shared import topics
from shared.loop import healthy
from shared.processes import BRIDGE_ROS1, BRIDGE_ROS2, CLI, EXPERIMENT, PROCESSES, SIM, VIEWER, Process, process_named

ROOT = Path(__file__).parents[2]
DOCKERFILE = (ROOT / "deploy" / "Dockerfile").read_text(encoding="utf-8")
COMPOSE = yaml.safe_load((ROOT / "docker-compose.yml").read_text(encoding="utf-8"))
REALTIME = yaml.safe_load((ROOT / "deploy" / "compose.realtime.yml").read_text(encoding="utf-8"))
SERVICES: dict[str, dict[str, Any]] = COMPOSE["services"]
SETTINGS = dict(
    line.split("=", 1) for line in (ROOT / ".env").read_text(encoding="utf-8").splitlines() if line[:1].isalpha()
)
OPERATOR, KEYS = "tandem", "keys"
"""Containers of the command line: the person's, and the one that makes everybody's keys before the others start."""
BY_ITSELF = [process.name for process in PROCESSES if process.started != "by hand"]
BRIDGES = {BRIDGE_ROS1.name: "ros1", BRIDGE_ROS2.name: "ros2"}
"""Whoever stands for a real robot, and the profile of the compose file that starts it."""
LASTING = [*BY_ITSELF, *BRIDGES, VIEWER.name]
"""Whoever runs until somebody ends it."""
CONFIG = "./deploy/config:/opt/tandem/deploy/config:ro"
PAGE = "127.0.0.1:${TANDEM_PAGE:-9090-9091}:9090-9091"

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


def words(command: str | list[str]) -> list[str]:
    return shlex.split(command) if isinstance(command, str) else command


def participant(name: str) -> str:
    """Whose certificate a container has."""
    return {OPERATOR: topics.OPERATOR, VIEWER.name: topics.PAGE, **dict.fromkeys(BRIDGES, topics.ROBOT)}.get(name, name)


CLOSED = [name for name in SERVICES if name != KEYS]


def started(profiles: str) -> set[str]:
    """Whoever `docker compose up` starts, given COMPOSE_PROFILES."""
    return {
        name
        for name, service in SERVICES.items()
        if not service.get("profiles") or set(service["profiles"]) & set(profiles.split(","))
    }


def test_every_process_of_the_carry_has_a_container() -> None:
    assert set(SERVICES) == {*LASTING, EXPERIMENT.name, OPERATOR, KEYS}
    assert started(SETTINGS["COMPOSE_PROFILES"]) == {*BY_ITSELF, VIEWER.name, EXPERIMENT.name, KEYS}
    assert SETTINGS["TANDEM_CONFIG"] == "carry.toml"


@pytest.mark.parametrize("bridge", BRIDGES)
def test_a_real_robot_comes_without_the_simulation_and_nothing_starts_that_beside(bridge: str) -> None:
    there = started(BRIDGES[bridge])
    assert there == {*BY_ITSELF, bridge, VIEWER.name, KEYS} - {SIM.name}
    # Nothing needs what is not there; and `run experiment` starts whatever it needs, whichever profile that is of.
    for name in (*there, EXPERIMENT.name, OPERATOR):
        assert not {SIM.name, *BRIDGES} & set(SERVICES[name].get("depends_on", {}))


def test_a_robot_of_ros_1_dials_back_the_ports_that_are_published_at_this_machine_s_address() -> None:
    service = SERVICES[BRIDGE_ROS1.name]
    assert service["environment"]["ROS_IP"] == "${ROS_IP:-127.0.0.1}"
    assert service["ports"] == ["${ROS_IP:-127.0.0.1}:7450-7451:7450-7451"]
    assert " --set ports=7450 " in service["command"]


@every_service
def test_it_runs_its_module_in_its_image_as_its_user(name: str) -> None:
    service, process = SERVICES[name], process_of(name)
    assert service["build"]["target"] == process.image
    assert service["image"] == f"tandem-{process.image}"
    command = [*service.get("entrypoint", []), *words(service.get("command", []))]
    assert command[command.index("python") :][:3] == ["python", "-m", process.module]
    assert service["user"] == ("root" if name in CAPABILITIES else process.known_as)


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
    further = {VIEWER.name: topics.PAGE, **dict.fromkeys(BRIDGES, topics.ROBOT)}
    networks = [] if name == KEYS else ["bus", *([further[name]] if name in further else [])]
    assert [*service.get("networks", [])] == networks
    assert service.get("network_mode") == ("none" if name == KEYS else None)
    assert name in (VIEWER.name, BRIDGE_ROS1.name) or "ports" not in service
    assert not {"privileged", "devices", "pid", "ipc"} & service.keys()
    own = {f"{name}:/home/{name}", "./runs:/opt/tandem/runs" if name == EXPERIMENT.name else CONFIG}
    assert {volume for volume in service.get("volumes", []) if "/keys/" not in volume} <= own


@pytest.mark.parametrize("name", [process.name for process in PROCESSES if process.linked and process.name in SERVICES])
def test_the_chain_dials_each_other_by_the_names_that_their_certificates_have(name: str) -> None:
    service, publisher = SERVICES[name], process_of(name).publisher
    assert service["environment"]["TANDEM_LINKS"] == "tls/{name}:7448"
    named = {name, *(service["networks"]["bus"]["aliases"] if isinstance(service["networks"], dict) else [])}
    assert publisher in named


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
    assert made["environment"]["TANDEM_KEYS"].split() == [*owners], "both bridges are the robot's"
    assert made["volumes"] == [f"keys-{owner}:/keys/{owner}" for owner in ("authority", *owners)]
    assert {f"keys-{owner}" for owner in ("authority", *owners)} <= set(COMPOSE["volumes"])
    # An empty volume takes owner and mode of the image's directory.
    directories = re.search(r"^RUN for keys in ([^;]+); do", DOCKERFILE, re.MULTILINE)
    assert directories is not None
    assert dict(re.findall(r"(\w+)=(\w+)", directories[1])) == {"authority": "root", **owners}


@pytest.mark.parametrize("name", LASTING)
def test_it_is_asked_how_it_is_and_restarted(name: str) -> None:
    service = SERVICES[name]
    assert service["healthcheck"]["test"][-1] == str(Path(healthy.__file__).relative_to(ROOT))
    assert service["tmpfs"] == ["/tmp"] and "TANDEM_HEALTH=/tmp/" in DOCKERFILE
    assert service["restart"] == "unless-stopped"


def test_the_page_alone_is_reached_from_this_machine_and_old_and_new_compose_read_it() -> None:
    outgoing = {"com.docker.network.bridge.enable_ip_masquerade": "false"}
    assert COMPOSE["networks"] == {
        "bus": {"internal": True},
        topics.ROBOT: None,
        topics.PAGE: {"driver_opts": outgoing},
    }
    # It listens where the bus does not lead: the name is that of its address on the other network alone.
    assert SERVICES[VIEWER.name]["networks"] == {"bus": {}, topics.PAGE: {"aliases": [topics.PAGE]}}
    assert SERVICES[VIEWER.name]["ports"] == [PAGE]
    command = SERVICES[VIEWER.name]["command"]
    assert command[command.index("--listen") + 1] == topics.PAGE
    for file in (COMPOSE, REALTIME):
        assert not {"version", "name", "include"} & file.keys()
    assert set(REALTIME["services"]) <= set(SERVICES)


@every_process
def test_its_image_has_its_user_and_all_that_it_needs(process: Process) -> None:
    assert re.search(rf"^FROM \w+ AS {process.image}$", DOCKERFILE, re.MULTILINE)
    users = re.search(r"^RUN for name in ([\w ]+); do", DOCKERFILE, re.MULTILINE)
    assert users is not None and process.known_as in users[1].split()
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


def test_an_image_without_the_code_of_the_others_is_of_a_process_that_imports_none() -> None:
    alone = re.search(r"for name in ([^;]+); do \\\n +mkdir", DOCKERFILE)
    assert alone is not None
    for name in alone[1].split():
        assert [process.name for process in PROCESSES if process.image == name] == [name]
        assert f"COPY --from=code /only/{name} /opt/tandem" in DOCKERFILE
        code = "".join(file.read_text() for file in (ROOT / "services" / name).rglob("*.py"))
        assert set(re.findall(r"(?:from|import) services\.(\w+)", code)) <= {name}
