"""`tandem stop` and `tandem resume`: the latch of the robot's gate."""

from __future__ import annotations

import time
from typing import Annotated

import typer

from services.cli.common import DEFAULT_ENDPOINT, DEFAULT_ROBOT, Connect, Robot, open_bus, refuse, unheard
from shared import topics
from shared.messages import ControlStatus, RobotStatus, Stop
from shared.wire.bus import Bus
from shared.wire.client import Client, forbidden
from shared.wire.subscription import Subscription

CONFIRM_WITHIN = 3.0  # [s]
REPEAT = 0.1  # [s]


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
    """Says it until the robot's gate shows it: one message alone could be lost, and a stop must not be."""
    client = Client(bus)
    robot: Subscription[RobotStatus] = client.watch(topics.STATE_ROBOT)
    controller: Subscription[ControlStatus] = client.watch(topics.CONTROL_STATUS)
    deadline = time.monotonic() + CONFIRM_WITHIN
    latched = ""
    while time.monotonic() < deadline:
        client.publish(topics.STOP, message)
        time.sleep(REPEAT)
        reason = controller.latest.message.reason if controller.latest else ""
        latched = reason if not message.engaged and "latched" in reason else ""
        shown = robot.latest
        if shown is not None and (shown.message.mode == "stopped") == message.engaged and not latched:
            return
    # It was sent all the same: a stop is worth trying.
    if why := forbidden(topics.STOP):
        refuse(why, 1)
    if robot.latest is None:
        refuse(f"sent, but no robot has answered: {unheard(robot)}", 1)
    if latched:
        refuse(f"the robot is released, but not the controller: {latched}", 1)
    wanted, mode = "stopped" if message.engaged else "released", robot.latest.message.mode
    refuse(f"sent, but the robot does not show {wanted} within {CONFIRM_WITHIN:g} s (it is {mode})", 1)
