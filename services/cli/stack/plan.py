"""Which processes make a stack, with which options, and where a running stack's options are remembered."""

from __future__ import annotations

import json
import os
import socket
import tempfile
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from services.cli.common import refuse
from shared.loop.config import config_text, service_assignment
from shared.processes import FURTHER, STACK, process_named
from shared.wire.endpoint import DEFAULT_ENDPOINT, BusError
from shared.wire.links import usual_links
from shared.wire.zenoh import ZenohBus

STARTABLE = (*STACK, *FURTHER)
"""Services that a stack may have besides its router."""


@dataclass(frozen=True)
class Plan:
    """A stack to start: one router and the services of one robot on it."""

    robot: str
    endpoint: str
    config: Path | None = None
    settings: dict[str, list[str]] = field(default_factory=dict)
    further: tuple[str, ...] = ()
    links: str | None = None

    @property
    def services(self) -> tuple[str, ...]:
        """All services of the stack."""
        return (*STACK, *self.further)

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
        """Writes the options down, so that `tandem start` and `tandem status` know them."""
        path = _memory(self.robot, self.endpoint)
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        stored = {
            "config": str(self.config.resolve()) if self.config else None,
            "settings": self.settings,
            "further": self.further,
            "links": self.links,
        }
        path.write_text(json.dumps(stored), encoding="utf-8")

    def forget(self) -> None:
        """Removes what `remember` wrote."""
        _memory(self.robot, self.endpoint).unlink(missing_ok=True)


def remembered(robot: str, endpoint: str) -> Plan | None:
    """The plan of the stack that runs there, if `tandem up` or `tandem run` started it."""
    try:
        stored = json.loads(_memory(robot, endpoint).read_text(encoding="utf-8"))
    except (FileNotFoundError, json.JSONDecodeError):
        return None
    config = Path(stored["config"]) if stored["config"] else None
    return Plan(robot, endpoint, config, stored["settings"], tuple(stored.get("further", ())), stored.get("links"))


def parse_settings(settings: Sequence[str]) -> dict[str, list[str]]:
    """`controller.law="paper"` and the like -> service -> `law="paper"`; refuses what names no service of the stack."""
    table: dict[str, list[str]] = {}
    for setting in settings:
        try:
            service, key, value = service_assignment(setting)
        except ValueError:
            refuse(f"--set {setting!r}: wanted SERVICE.NAME=VALUE, such as --set 'controller.law=\"paper\"'")
        if service not in STARTABLE:
            refuse(f"--set {setting!r}: {service!r} is no service of the stack; choose from {', '.join(STARTABLE)}")
        table.setdefault(service, []).append(f"{key}={value}")
    return table


def check_further(services: Sequence[str]) -> tuple[str, ...]:
    """The services, each once, if a stack can have them."""
    for service in services:
        if service not in FURTHER:
            refuse(f"--with {service!r}: choose from {', '.join(FURTHER)}")
    return tuple(dict.fromkeys(services))


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
        refuse(f"--router {endpoint}: wanted tcp/HOST:PORT, such as {DEFAULT_ENDPOINT}")
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, int(port)))
        except OSError as problem:
            there = ", ".join(sorted(_living(endpoint, robot)))
            first = (
                f"{there} of robot {robot} run there. To take over, end that stack first (Ctrl-C where it runs)."
                if there
                else "is another program running there?"
            )
            refuse(
                f"port {port} on {host} cannot be used ({problem.strerror}): {first} "
                f"Or choose another one: --router tcp/127.0.0.1:{int(port) + 1}",
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


def _memory(robot: str, endpoint: str) -> Path:
    place = "".join(letter if letter.isalnum() else "-" for letter in f"{robot} {endpoint}")
    return Path(tempfile.gettempdir()) / f"tandem-{os.getuid()}" / f"{place}.json"
