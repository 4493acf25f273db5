"""`tandem certify`: what the certified law guarantees with the present configuration."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterable
from typing import Annotated, Any

import typer

from services.cli.common import DEFAULT_ENDPOINT, DEFAULT_ROBOT, Connect, Robot
from services.cli.param import shown
from services.cli.stack.children import command
from shared import topics
from shared.parameters import Refused
from shared.wire.bus import NoReply
from shared.wire.client import Client
from shared.wire.zenoh import BusError, ZenohBus

CONTEXT = {"allow_extra_args": True, "ignore_unknown_options": True}
FOUND_WITHIN = 1.0  # [s]


def certify(
    context: typer.Context,
    robot: Robot = DEFAULT_ROBOT,
    connect: Connect = DEFAULT_ENDPOINT,
    offline: Annotated[
        bool, typer.Option("--offline", help="Do not ask a running controller; use --config, --set.")
    ] = False,
) -> None:
    """Certified speeds, worst excess and what limits them, for the running controller or for given options.

    Further options are those of python -m services.controller.certify: --config, --set, --force-limit,
    --torque-limit, --force-error, --torque-error, --environment-speed, --orientation, --json.
    """
    given = list(context.args)
    chosen = any(argument.startswith(("--config", "--set")) for argument in given)
    present = [] if offline or chosen else _present(robot, connect)
    if present:
        typer.echo(f"for the controller that runs as {robot} on {connect}", err=True)
    elif not (offline or chosen):
        typer.echo(f"no controller answers as {robot} on {connect}: for the default parameters", err=True)
    sys.stdout.flush()
    os.execv(sys.executable, command("controller.certify", [*present, *given]))


def _present(robot: str, connect: str) -> list[str]:
    """Options that describe the running controller: its parameters, target and error bound; none if there is none."""
    deadline = time.monotonic() + FOUND_WITHIN
    try:
        bus = ZenohBus(robot, connect, give_up=lambda: time.monotonic() > deadline)
    except BusError:
        return []
    try:
        client = Client(bus)
        target, wrench = client.watch(topics.CONTROL_TARGET), client.watch(topics.WRENCH_EXTERNAL)
        parameters = client.ask(topics.CONTROL_PARAMETERS, {}, FOUND_WITHIN)["parameters"]
        options = [part for assignment in assignments(parameters) for part in ("--set", assignment)]
        while (target.latest is None or wrench.latest is None) and time.monotonic() < deadline:
            time.sleep(0.02)
        if target.latest is not None:
            options += ["--force-limit", _three(target.latest.message.force_limit)]
            options += ["--torque-limit", _three(target.latest.message.torque_limit)]
        if wrench.latest is not None:
            bound = wrench.latest.message.error_bound
            options += ["--force-error", _three(bound[:3]), "--torque-error", _three(bound[3:])]
        return options
    except (NoReply, Refused):
        return []
    finally:
        bus.close()


def assignments(parameters: dict[str, dict[str, Any]]) -> list[str]:
    """Values for ``--set`` that restore the parameters of a reply (name to row with ``value``), to the last digit."""
    values = {name: row["value"] for name, row in parameters.items()}
    return [
        f'{name}="{value}"' if isinstance(value, str) else f"{name}={shown(value)}"
        for name, value in values.items()
    ]


def _three(values: Iterable[float]) -> str:
    return ",".join(shown(float(value)) for value in values)
