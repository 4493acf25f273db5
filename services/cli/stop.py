"""`tandem stop` and `tandem resume`: the latch of the robot's gate."""

from __future__ import annotations

from typing import Annotated

import typer

from services.cli.common import DEFAULT_ENDPOINT, DEFAULT_ROBOT, Connect, Robot, open_bus, refuse, waiting
from shared import topics
from shared.messages import Stop
from shared.wire.bus import Bus
from shared.wire.client import Client
from shared.wire.latch import CONFIRM_WITHIN, Latch


def stop(
    reason: Annotated[str, typer.Argument(help="Shown to everybody who asks why.")] = "tandem stop",
    robot: Robot = DEFAULT_ROBOT,
    connect: Connect = DEFAULT_ENDPOINT,
) -> None:
    """Stop the robot: latched by its gate until `tandem resume`."""
    with open_bus(robot, connect) as bus:
        _latch(bus, Stop(engaged=True, reason=reason))
    typer.echo("stopped; release it with: tandem resume")


def resume(robot: Robot = DEFAULT_ROBOT, connect: Connect = DEFAULT_ENDPOINT) -> None:
    """Release a stop, and a controller that latched a sensor failure."""
    with open_bus(robot, connect) as bus:
        _latch(bus, Stop(engaged=False, reason="tandem resume"))
    typer.echo("released")


def _latch(bus: Bus, message: Stop) -> None:
    client = Client(bus)
    latch = Latch(client, client.watch(topics.STATE_ROBOT), client.watch(topics.CONTROL_STATUS))
    with waiting("said again and again, until the robot shows it", CONFIRM_WITHIN):
        problem = latch.say(message)
    if problem:
        refuse(problem, 1)
