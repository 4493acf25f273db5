"""`tandem certify`: what the certified law guarantees, for the running controller or for given options.

Of a running one it takes the limits in force and the error bound as they are now, and says whose they are.
"""

from __future__ import annotations

import os
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console
from rich.text import Text

from services.cli.common import DEFAULT_ENDPOINT, DEFAULT_ROBOT, AsJson, Connect, Robot, refuse, three
from services.cli.listing import Listing, show_json
from services.controller.guarantee import Statement, as_map, as_words
from services.controller.parameters import ControllerParameters
from shared import topics
from shared.clock import in_words
from shared.loop.config import Misconfigured, service_parameters
from shared.messages import ControlStatus, ControlTarget, ExternalWrench, TaskStatus
from shared.parameters import Refused
from shared.spatial import Array, rotation_matrix
from shared.wire.bus import NoReply
from shared.wire.client import Client, forbidden
from shared.wire.credentials import Credentials
from shared.wire.endpoint import BusError, NoRouter
from shared.wire.subscription import Received
from shared.wire.zenoh import ZenohBus

FOUND_WITHIN = 1.0  # [s]
LIMIT = (25.0,) * 3 + (10.0,) * 3
"""Limits [N, Nm] where nobody has asked for any."""
ERROR_BOUND = (0.6,) * 3 + (0.1,) * 3
"""Error bound [N, Nm] of a sensor that was tared, where none is heard."""


def certify(
    robot: Robot = DEFAULT_ROBOT,
    connect: Connect = DEFAULT_ENDPOINT,
    offline: Annotated[
        bool, typer.Option("--offline", help="Do not ask a running controller; use --config, --set.")
    ] = False,
    config: Annotated[Path | None, typer.Option(help="TOML file with a table [controller].")] = None,
    settings: Annotated[list[str], typer.Option("--set", help="NAME=VALUE in TOML; repeatable.")] = [],  # noqa: B006
    force_limit: Annotated[str, typer.Option(help="[N], one number or x,y,z; without it 25.")] = "",
    torque_limit: Annotated[str, typer.Option(help="[Nm], one number or x,y,z; without it 10.")] = "",
    force_error: Annotated[str, typer.Option(help="Error bound [N]; without it 0.6.")] = "",
    torque_error: Annotated[str, typer.Option(help="Error bound [Nm]; without it 0.1.")] = "",
    environment_speed: Annotated[float, typer.Option(help="[m/s]")] = 0.1,
    orientation: Annotated[
        list[str],
        typer.Option(help="X,Y,Z,W of the tool in base, to print the stiffness bound for, with --json; repeatable."),
    ] = [],  # noqa: B006
    as_json: AsJson = False,
) -> None:
    """Certified speeds, worst excess and what limits them, for the running controller or for given options."""
    chosen = offline or config is not None or bool(settings)
    running = None if chosen else _running(robot, connect)
    if running is not None:
        typer.echo(f"for the controller that runs as {robot} on {connect}: {running.said}", err=True)
    elif not chosen:
        typer.echo(f"no controller answers as {robot} on {connect}: for the default parameters", err=True)
    try:
        if running is None:
            file = config or os.environ.get("TANDEM_CONFIG") or None
            parameters = service_parameters("controller", ControllerParameters, file, settings)
            limit, error_bound = np.array(LIMIT), np.array(ERROR_BOUND)
        else:
            parameters, limit, error_bound = running.parameters, running.limit, running.error_bound
        for part, into, option, text in (
            (slice(3), limit, "--force-limit", force_limit),
            (slice(3, 6), limit, "--torque-limit", torque_limit),
            (slice(3), error_bound, "--force-error", force_error),
            (slice(3, 6), error_bound, "--torque-error", torque_error),
        ):
            if text:
                into[part] = _three(option, text)
        rotations = [_rotation(text) for text in orientation] or [np.eye(3)]
        given = parameters, limit, error_bound, environment_speed
        if as_json:
            show_json(as_map(*given, rotations))
        else:
            _show(as_words(*given))
    except (Misconfigured, ValueError) as problem:
        refuse(" ".join(str(problem).split()))


def _show(told: Statement) -> None:
    shown = Listing(*told.head)
    for row in told.rows:
        shown.add(*row)
    Console().print(*map(Text, (*told.before, "")), shown, *map(Text, ("", *told.after)), sep="\n")


@dataclass(frozen=True)
class Running:
    """What a running system says: parameters, limits and error bound (6,) [N, Nm], and in words whose these are."""

    parameters: ControllerParameters
    limit: Array
    error_bound: Array
    said: str


def _running(robot: str, connect: str) -> Running | None:
    """What the running controller is to be certified with; None if there is none."""
    deadline = time.monotonic() + FOUND_WITHIN
    try:
        credentials = Credentials.given(robot)
        if why := forbidden(topics.CONTROL_PARAMETERS):
            refuse(why)
        bus = ZenohBus(robot, connect, lambda: time.monotonic() > deadline, credentials=credentials)
    except NoRouter:
        return None
    except BusError as problem:
        refuse(str(problem))
    try:
        client = Client(bus)
        status, wrench = client.watch(topics.CONTROL_STATUS), client.watch(topics.WRENCH_EXTERNAL)
        target, task = client.watch(topics.CONTROL_TARGET), client.watch(topics.TASK_STATUS)
        table = client.ask(topics.CONTROL_PARAMETERS, {}, FOUND_WITHIN)["parameters"]
        heard = status, wrench, target, task
        while any(one.latest is None for one in heard) and time.monotonic() < deadline:
            time.sleep(0.02)
        latest = status.latest, wrench.latest, target.latest, task.latest
        return running(parameters_of(table), *latest, now_ns=client.clock.now_ns())
    except (NoReply, Refused):
        return None
    finally:
        bus.close()


def running(
    parameters: ControllerParameters,
    status: Received[ControlStatus] | None,
    wrench: Received[ExternalWrench] | None,
    target: Received[ControlTarget] | None,
    task: Received[TaskStatus] | None,
    now_ns: int,
) -> Running:
    """What was heard, each with its age; what nobody says is assumed, and that is said."""
    limit, error_bound = np.array(LIMIT), np.array(ERROR_BOUND)
    law = "" if parameters.law == "certified" else f"it runs law {parameters.law}, which promises none of this; "
    whose = f"limits {LIMIT[0]:g} N, {LIMIT[3]:g} Nm assumed, no target is in force"
    if status is not None and status.message.limit is not None and status.message.limit.any():
        limit = status.message.limit.copy()
        state, sender = status.message.state, _sender(target, task)
        whose = f"limits in force of the running controller ({state}), {_age(status, now_ns)}, target by {sender}"
    bound = f"error bound {ERROR_BOUND[0]:g} N, {ERROR_BOUND[3]:g} Nm assumed, no wrench is heard"
    if wrench is not None:
        error_bound = wrench.message.error_bound.copy()
        doubt = "" if wrench.header.valid else f", which is not valid ({wrench.message.fault or 'no fault named'})"
        bound = f"error bound of wrench/external, {_age(wrench, now_ns)}{_zero(wrench.message)}{doubt}"
    return Running(parameters, limit, error_bound, f"{law}{whose}; {bound}")


def _age(received: Received[Any], now_ns: int) -> str:
    return f"{(now_ns - received.arrival_ns) * 1e-9:.1f} s old"


def _zero(wrench: ExternalWrench) -> str:
    if wrench.zero_age is None:
        return ""
    return f", zero {in_words(wrench.zero_age)} old" if wrench.zero_age >= 0.0 else ", no zero of this run"


def _sender(target: Received[ControlTarget] | None, task: Received[TaskStatus] | None) -> str:
    """Who sends the target: a process sends all its topics in one session."""
    if target is None:
        return "somebody who is silent now"
    return "task" if task is not None and task.header.session == target.header.session else "another program"


def parameters_of(table: dict[str, dict[str, Any]]) -> ControllerParameters:
    """The parameters of a reply (name to row with ``value``), to the last digit."""
    return ControllerParameters.of({name: row["value"] for name, row in table.items()})


def _three(option: str, text: str) -> Array:
    values = np.array(three(option, text))
    if not np.all((values >= 0.0) & (values < 1e6)):
        refuse(f"{option} {text!r}: wanted one number or three, separated by commas, not negative")
    return values


def _rotation(text: str) -> Array:
    try:
        return rotation_matrix([float(part) for part in text.split(",")])
    except ValueError:
        raise Misconfigured(f"--orientation {text!r}: wanted a unit quaternion x,y,z,w, separated by commas") from None
