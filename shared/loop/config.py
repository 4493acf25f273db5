"""Command line, environment and configuration file of a service process."""

from __future__ import annotations

import argparse
import json
import os
import re
import sys
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, NoReturn, TypeVar

from shared.parameters import Parameters, Refused
from shared.processes import SERVICES
from shared.wire.endpoint import DEFAULT_ENDPOINT
from shared.wire.links import NONE

P = TypeVar("P", bound=Parameters)

_CHUNK = re.compile(r"[A-Za-z0-9_-]+")
_WORD = re.compile(r"[^\W\d_][\w-]*")


class Misconfigured(Exception):
    """A bad option, environment variable or file; the text is one line for the user."""


@dataclass(frozen=True)
class Settings(Generic[P]):
    """Where a process is connected, and its parameters."""

    robot: str
    connect: str
    links: str
    secure: str
    parameters: P


class OneLineParser(argparse.ArgumentParser):
    """Reports a bad option in one line."""

    def error(self, message: str) -> NoReturn:
        """Raise instead of printing the usage."""
        raise Misconfigured(f"{message}. See --help")


def bus_parser(process: str) -> OneLineParser:
    """The options that every process on the bus has."""
    parser = OneLineParser(prog=f"python -m services.{process}")
    parser.add_argument("--robot", default=os.environ.get("TANDEM_ROBOT", "tiago"), help="first chunk of every key")
    parser.add_argument(
        "--connect", default=os.environ.get("TANDEM_CONNECT", DEFAULT_ENDPOINT), help="endpoint of the Zenoh router"
    )
    parser.add_argument(
        "--secure",
        default=os.environ.get("TANDEM_SECURE", ""),
        metavar="FOLDER",
        help="certificates of this process, made by `tandem keys`, for a closed network",
    )
    return parser


def service_parser(service: str) -> OneLineParser:
    """The options that every service process has."""
    parser = bus_parser(service)
    parser.add_argument(
        "--links",
        default=os.environ.get("TANDEM_LINKS") or NONE,
        metavar="ENDPOINT",
        help="direct links to the other processes of the chain, which need them too: sockets, on one machine, or an "
        "endpoint with {name}, such as tcp/{name}:7448 (default none: all goes through the router)",
    )
    parser.add_argument(
        "--config", default=os.environ.get("TANDEM_CONFIG") or None, help="TOML file, one table per service"
    )
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="a parameter, value in TOML; wins over the file"
    )
    return parser


def settings(service: str, parameters: type[P], arguments: Sequence[str] | None = None) -> Settings[P]:
    """The settings of a service process.

    Raises:
        Misconfigured: with one line that names the option or key, what was given and what is allowed.
    """
    options = service_parser(service).parse_args(arguments)
    chosen = service_parameters(service, parameters, options.config, options.set)
    return Settings(robot_name(options.robot), options.connect, options.links, options.secure, chosen)


def robot_name(name: str) -> str:
    """The name itself.

    Raises:
        Misconfigured: if it cannot be one chunk of a key.
    """
    if not _CHUNK.fullmatch(name):
        raise Misconfigured(f"--robot {name!r}: wanted letters, digits, - and _ only")
    return name


def service_parameters(service: str, parameters: type[P], config: str | Path | None, assignments: Sequence[str]) -> P:
    """Parameters of a service from a file's table of its name and from ``key=value`` assignments, which win.

    Raises:
        Misconfigured: with one line.
    """
    values: dict[str, Any] = {}
    source = "default"
    if config is not None:
        source = f"--config {config}"
        values |= _table(Path(config), service)
    for text in assignments:
        try:
            name, value = assignment(text)
        except ValueError:
            raise Misconfigured(f"--set {text}: wanted key=value") from None
        try:
            values[name] = value_of(value)
        except ValueError:
            raise Misconfigured(f'--set {text}: the value is not TOML; text needs quotes: {name}="..."') from None
        source = "--set" if config is None else f"{source} or --set"
    try:
        return parameters.of(values)
    except Refused as problem:
        raise Misconfigured(f"{source}: {problem}") from None


def _table(path: Path, service: str) -> Mapping[str, Any]:
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as problem:
        raise Misconfigured(f"--config {path}: {problem.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as problem:
        raise Misconfigured(f"--config {path}: not TOML ({problem})") from None
    unknown = [key for key, value in content.items() if isinstance(value, dict) and key not in (*SERVICES, service)]
    if unknown:
        raise Misconfigured(f"--config {path}: [{unknown[0]}] is no service; there are {', '.join(SERVICES)}")
    table = content.get(service, {})
    if not isinstance(table, dict):
        raise Misconfigured(f"--config {path}: {service} is {table!r}, wanted a table [{service}]")
    stray = [key for key, value in content.items() if not isinstance(value, dict)]
    if stray:
        raise Misconfigured(f"--config {path}: {stray[0]} stands outside a table; write it below [{service}]")
    return table


def config_text(settings: Mapping[str, Mapping[str, Any]]) -> str:
    """Parameters (numbers, texts, booleans and lists of them) of services as a file for `--config`."""
    tables = (
        "".join((f"[{service}]\n", *(f"{name} = {json.dumps(value)}\n" for name, value in values.items())))
        for service, values in settings.items()
    )
    return "\n".join(tables)


def assignment(text: str) -> tuple[str, str]:
    """Name and value of NAME=VALUE as they are written; `value_of` reads the value.

    Raises:
        ValueError: it is no such text.
    """
    name, equals, value = text.partition("=")
    if not equals or not name.strip().isidentifier():
        raise ValueError(f"{text!r} is no NAME=VALUE")
    return name.strip(), value.strip()


def service_assignment(text: str) -> tuple[str, str, str]:
    """Service, name and value of SERVICE.NAME=VALUE as they are written.

    Raises:
        ValueError: it is no such text.
    """
    service, dot, rest = text.partition(".")
    if not dot or "=" in service:
        raise ValueError(f"{text!r} is no SERVICE.NAME=VALUE")
    return service.strip(), *assignment(rest)


def value_of(text: str) -> Any:
    """A value in TOML; a bare word is text, so that law=paper works without quotes inside quotes: letters first, then
    digits, too.

    Raises:
        ValueError: it is neither.
    """
    try:
        table = tomllib.loads(f"value = {text}")
    except (tomllib.TOMLDecodeError, RecursionError):
        if _WORD.fullmatch(text):
            return text
        raise ValueError(f"{text!r} is no TOML value") from None
    if len(table) > 1:
        raise ValueError(f"{text!r} is more than a value")
    return table["value"]


def complain(service: str, problem: Exception) -> int:
    """Print the one line of a bad configuration; returns the exit status for it."""
    print(f"{service}: {one_line(problem)}", file=sys.stderr, flush=True)
    return 2


def one_line(problem: Exception) -> str:
    """What was wrong, in one line; a file is named first."""
    text = str(problem)
    if isinstance(problem, OSError) and problem.filename and problem.strerror:
        text = f"{problem.filename}: {problem.strerror}"
    # Whatever was given may hold line breaks.
    return " ".join(text.split())
