"""Which processes make a stack, with which options, and where a running stack's options are remembered."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from services.cli import memory
from services.cli.common import refuse
from services.cli.ports import taken
from shared.loop.config import config_text, service_assignment
from shared.processes import FURTHER, PROCESSES, SIM, STACK, process_named
from shared.topics import ROBOT
from shared.wire.endpoint import DEFAULT_ENDPOINT, BusError
from shared.wire.links import usual_links
from shared.wire.zenoh import ZenohBus

STARTABLE = (*STACK, *FURTHER)
"""Services that a stack may have besides its router."""
IN_ITS_PLACE = tuple(process.name for process in PROCESSES if process.publisher == ROBOT and process is not SIM)
"""Processes that a stack may have for a robot in place of the simulation."""


@dataclass(frozen=True)
class Plan:
    """A stack to start: one router and the services of one robot on it."""

    robot: str
    endpoint: str
    config: Path | None = None
    settings: dict[str, list[str]] = field(default_factory=dict)
    further: tuple[str, ...] = ()
    links: str | None = None
    robot_process: str = SIM.name

    @property
    def services(self) -> tuple[str, ...]:
        """Processes of all services of the stack."""
        return (*(self.robot_process if name == SIM.name else name for name in STACK), *self.further)

    @property
    def expected(self) -> tuple[str, ...]:
        """Names by which they are known to each other."""
        return tuple(process_named(name).known_as for name in self.services)

    def arguments(self, name: str) -> list[str]:
        """Command line of the router or one service; KeyError if there is none of that name."""
        process = process_named(name)
        arguments = process.arguments(self.robot, self.endpoint)
        if process.linked:
            arguments += ["--links", self.links or usual_links(self.endpoint)]
        if self.config and process.settable:
            arguments += ["--config", str(self.config.resolve())]
        return arguments + [part for setting in self.settings.get(name, []) for part in ("--set", setting)]

    def remember(self) -> None:
        """Writes the options down, so that the commands that speak to the stack know them."""
        options = {
            "config": str(self.config.resolve()) if self.config else None,
            "settings": self.settings,
            "further": self.further,
            "links": self.links,
            "robot_process": self.robot_process,
        }
        memory.keep(self.robot, self.endpoint, options)

    def forget(self) -> None:
        """Removes what `remember` wrote."""
        memory.forget(self.robot, self.endpoint)


def remembered(robot: str, endpoint: str) -> Plan | None:
    """The plan of the stack that runs there, if `tandem up` or `tandem run` started it."""
    kept = memory.kept(robot, endpoint)
    if kept is None:
        return None
    config = Path(kept["config"]) if kept["config"] else None
    further, robot_process = tuple(kept.get("further", ())), kept.get("robot_process", SIM.name)
    return Plan(robot, endpoint, config, kept["settings"], further, kept.get("links"), robot_process)


def parse_settings(settings: Sequence[str]) -> dict[str, list[str]]:
    """`controller.law="paper"` and the like -> service -> `law="paper"`; refuses what names no service of the stack."""
    table: dict[str, list[str]] = {}
    for setting in settings:
        try:
            service, key, value = service_assignment(setting)
        except ValueError:
            refuse(f"--set {setting!r}: wanted SERVICE.NAME=VALUE, such as --set 'controller.law=\"paper\"'")
        if service not in (*STARTABLE, *IN_ITS_PLACE):
            known = ", ".join((*STARTABLE, *IN_ITS_PLACE))
            refuse(f"--set {setting!r}: {service!r} is no service of the stack; choose from {known}")
        table.setdefault(service, []).append(f"{key}={value}")
    return table


def check_further(services: Sequence[str]) -> tuple[str, ...]:
    """The services, each once, if a stack can have them."""
    for service in services:
        if service not in FURTHER:
            refuse(f"--with {service!r}: choose from {', '.join(FURTHER)}")
    return tuple(dict.fromkeys(services))


def check_bridge(name: str) -> str:
    """The process that stands for the robot, if a stack can have it; the simulation if none is named."""
    if name and name not in IN_ITS_PLACE:
        refuse(f"--bridge {name!r}: choose from {', '.join(IN_ITS_PLACE)}")
    return name or SIM.name


def check_config(path: Path | None) -> Path | None:
    """The file, if it exists and is TOML; its contents are checked by the services themselves."""
    if path is None:
        return None
    try:
        tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as problem:
        refuse(f"--config {path}: {problem.strerror or problem}")
    except tomllib.TOMLDecodeError as problem:
        refuse(f"--config {path}: {problem}")
    return path


def write_config(settings: Mapping[str, Mapping[str, Any]], path: Path) -> Path:
    """Writes parameters (numbers, texts, booleans and lists of them) as a file for `--config`; returns its path."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(config_text(settings), encoding="utf-8")
    return path


def check_port(endpoint: str, robot: str) -> None:
    """Refuses an endpoint that is no loopback TCP address or whose port is taken, and names the stack that is there."""
    protocol, _, address = endpoint.partition("/")
    host, _, port = address.rpartition(":")
    if protocol != "tcp" or not port.isdigit() or not 0 < int(port) < 65536:
        refuse(f"--connect {endpoint}: wanted tcp/HOST:PORT, such as {DEFAULT_ENDPOINT}")
    if problem := taken(int(port), host):
        there = ", ".join(sorted(_living(endpoint, robot)))
        first = (
            f"{there} of robot {robot} run there. To take over, end that stack first (Ctrl-C where it runs)."
            if there
            else "is another program running there?"
        )
        refuse(
            f"port {port} on {host} cannot be used ({problem.strerror}): {first} "
            f"Or choose another one: --connect tcp/127.0.0.1:{int(port) + 1}",
            status=1,
        )


def _living(endpoint: str, robot: str) -> set[str]:
    """Services of a robot that live at an endpoint, as far as a router answers there."""
    try:
        bus = ZenohBus(robot, endpoint, give_up=lambda: True)
    except BusError:
        return set()
    try:
        return bus.living()
    finally:
        bus.close()
