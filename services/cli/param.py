"""`tandem param get|set`: parameters of running services."""

from __future__ import annotations

from typing import Annotated, Any

import typer
from rich.console import Console

from services.cli.common import (
    DEFAULT_ENDPOINT,
    DEFAULT_ROBOT,
    AsJson,
    Connect,
    Robot,
    ask,
    example,
    open_bus,
    refuse,
)
from services.cli.listing import Listing, show_json
from shared.loop.config import service_assignment, value_of
from shared.topics import PARAMETER_QUERIES, Query

app = typer.Typer(help="Parameters of running services.")
QUERIES = {query.server: query for query in PARAMETER_QUERIES}


@app.command("get", epilog=example("tandem param get controller.law"))
def get(
    name: Annotated[str, typer.Argument(help="SERVICE or SERVICE.NAME, such as controller.law.")],
    as_json: AsJson = False,
    robot: Robot = DEFAULT_ROBOT,
    connect: Connect = DEFAULT_ENDPOINT,
) -> None:
    """Show parameters: value, unit, allowed range, meaning. A single one prints its value alone."""
    service, _, wanted = name.partition(".")
    query = _query(service)
    with open_bus(robot, connect) as bus:
        parameters = ask(bus, query, {})["parameters"]
    if wanted and wanted not in parameters:
        refuse(f"{name}: {service} has no such parameter; it has {', '.join(parameters)}")
    if as_json:
        chosen = {wanted: parameters[wanted]} if wanted else parameters
        show_json({"robot": robot, "endpoint": connect, "service": service, "parameters": chosen})
    elif not wanted:
        Console().print(_listing(parameters))
    else:
        typer.echo(shown(parameters[wanted]["value"]))


@app.command("set", epilog=example("tandem param set controller.max_linear=0.1"))
def set_(
    settings: Annotated[list[str], typer.Argument(help="SERVICE.NAME=VALUE in TOML, e.g. controller.max_linear=0.1")],
    as_json: AsJson = False,
    robot: Robot = DEFAULT_ROBOT,
    connect: Connect = DEFAULT_ENDPOINT,
) -> None:
    """Change parameters of a running service, all of one service or none; out of range is refused."""
    changes: dict[str, dict[str, Any]] = {}
    for setting in settings:
        try:
            service, parameter, text = service_assignment(setting)
        except ValueError:
            refuse(f"{setting!r}: wanted SERVICE.NAME=VALUE, such as controller.max_linear=0.1")
        _query(service)
        changes.setdefault(service, {})[parameter] = read(text)
    changed: dict[str, dict[str, Any]] = {}
    with open_bus(robot, connect) as bus:
        for service, values in changes.items():
            parameters = ask(bus, QUERIES[service], {"set": values})["parameters"]
            changed[service] = {parameter: parameters[parameter] for parameter in values}
            for parameter in () if as_json else values:
                typer.echo(f"{service}.{parameter} = {shown(parameters[parameter]['value'])}")
    if as_json:
        show_json({"robot": robot, "endpoint": connect, "changed": changed})


def read(text: str) -> Any:
    """A value as it is typed; refuses what is none."""
    try:
        return value_of(text)
    except ValueError:
        refuse(f'{text!r} is no TOML value: wanted a number, "text", true, false or [a, b, c]')


def shown(value: Any) -> str:
    """A value as it can be typed in again, in TOML; a number with all its digits."""
    if isinstance(value, dict):
        return f"{{{', '.join(f'{name} = {shown(part)}' for name, part in value.items())}}}"
    if isinstance(value, list):
        return f"[{', '.join(shown(element) for element in value)}]"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        short = f"{value:g}"
        return short if float(short) == value else repr(value)
    return str(value)


def _query(service: str) -> Query:
    if service not in QUERIES:
        refuse(f"{service!r} has no parameters that can be changed while it runs; choose from {', '.join(QUERIES)}")
    return QUERIES[service]


def _listing(parameters: dict[str, dict[str, Any]]) -> Listing:
    shows = Listing("parameter", "value", "unit", "allowed", "meaning")
    for name, row in parameters.items():
        shows.add(name, shown(row["value"]), row["unit"], _range(row["min"], row["max"]), row["doc"])
    return shows


def _range(low: float | None, high: float | None) -> str:
    if low is None and high is None:
        return ""
    if high is None:
        return f"≥ {low:g}"
    return f"≤ {high:g}" if low is None else f"{low:g} … {high:g}"
