"""`tandem hold`: a pose to hold within limits."""

from __future__ import annotations

from typing import Annotated

import numpy as np
import typer

from services.cli.common import (
    DEFAULT_ENDPOINT,
    DEFAULT_ROBOT,
    Connect,
    Robot,
    go_first,
    open_bus,
    refuse,
    stop_event,
    three,
    unheard,
)
from services.cli.health.diagnose import control_line
from shared import topics
from shared.messages import ControlTarget
from shared.schema.fields import InvalidField
from shared.spatial import quaternion_from_rpy
from shared.wire.client import Client, forbidden

REPEAT = 0.1  # [s] between two messages of the target


def hold(
    pose: Annotated[list[float], typer.Argument(help="X Y Z [m] ROLL PITCH YAW [rad] of the tool in base.")],
    force_limit: Annotated[str, typer.Option(help="Largest force [N]: one number, or x,y,z.")] = "25",
    torque_limit: Annotated[str, typer.Option(help="Largest torque [Nm]: one number, or x,y,z.")] = "10",
    robot: Robot = DEFAULT_ROBOT,
    connect: Connect = DEFAULT_ENDPOINT,
) -> None:
    """Have the robot hold a pose within limits, until Ctrl-C (the last target then stays in force). Tare first."""
    target = make_target(pose, three("--force-limit", force_limit), three("--torque-limit", torque_limit))
    with open_bus(robot, connect) as bus:
        if why := forbidden(topics.CONTROL_TARGET):
            refuse(why)
        client = Client(bus, name="hold")
        status, turn = client.watch(topics.CONTROL_STATUS), client.publisher.share(topics.CONTROL_TARGET)
        end, shown, asked = stop_event(), "", False
        while not end.wait(REPEAT):
            go_first(turn)
            if not turn.listened:
                continue
            if not asked:
                asked = True
                typer.echo(f"asking for {pose} with {force_limit} N, {torque_limit} Nm (Ctrl-C ends this command)")
            client.publish(topics.CONTROL_TARGET, target)
            line = unheard(status) or control_line(status.latest.message if status.latest else None)[0]
            if line.split(":")[0] != shown:
                shown = line.split(":")[0]
                typer.echo(f"controller: {line}")
        missing = unheard(status)
        followed = status.latest is not None and status.latest.message.state in ("tracking", "yielding") and not missing
    typer.echo("the last target stays in force" if asked and followed else f"nothing is held: {missing or line}")


def make_target(pose: list[float], force: list[float], torque: list[float]) -> ControlTarget:
    """The target message; refuses with the reason what no controller may be given."""
    if len(pose) != 6:
        refuse(f"a pose has six numbers (x y z roll pitch yaw), got {len(pose)}")
    try:
        return ControlTarget(
            position=np.array(pose[:3]),
            orientation=quaternion_from_rpy(*pose[3:]),
            force_limit=np.array(force),
            torque_limit=np.array(torque),
        )
    except InvalidField as problem:
        refuse(str(problem))
