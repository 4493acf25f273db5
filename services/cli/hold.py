"""`tandem hold`: a pose to hold within limits."""

from __future__ import annotations

import math
import time
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
)
from services.cli.health.diagnose import control_line
from services.wrench.averaging import AXES, UNITS
from shared import topics
from shared.messages import ControlStatus, ControlTarget, EndEffector
from shared.robot.side import at_present
from shared.schema.fields import InvalidField
from shared.spatial import pose_error, quaternion_from_rpy, rotation_matrix
from shared.wire.client import Client, forbidden, unheard

REPEAT = 0.1  # [s] between two messages of the target
TELL = 2.0  # [s] between two words on the way
NEAR, NEAR_TURN = 0.005, 0.02  # [m], [rad]: the pose is reached


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
        tool, gate = client.watch(topics.STATE_EE), client.watch(topics.STATE_ROBOT)
        end, shown, asked, way = stop_event(), "", False, Way(target)
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
            if tool.latest and status.latest and not unheard(status):
                reason = gate.latest.message.reason if gate.latest else ""
                if told := way.told(time.monotonic(), tool.latest.message, status.latest.message, reason):
                    typer.echo(told)
        missing = unheard(status)
        followed = status.latest is not None and status.latest.message.state in ("tracking", "yielding") and not missing
    if asked and followed:
        typer.echo(f"{way.left or 'the tool was not heard'}; the last target stays in force")
    else:
        typer.echo(f"nothing is held: {missing or line}")


class Way:
    """How far the tool has got to the pose, and what holds it back.

    Attributes:
        left: the way left in words, as it was last; empty before the tool was heard.
    """

    def __init__(self, target: ControlTarget) -> None:
        self.left = ""
        self._target = target
        self._rotation = rotation_matrix(target.orientation)
        self._at = -math.inf  # [s] when it was told last
        self._there = False

    def told(self, now: float, tool: EndEffector, status: ControlStatus, gate: str) -> str:
        """What is to be told at a time [s] on the steady clock: the arrival, and the way every `TELL`; else empty.

        Args:
            now: steady clock [s].
            tool: where it is.
            status: of the controller.
            gate: the reason that the robot's gate gives.
        """
        error = pose_error(tool.position, rotation_matrix(tool.orientation), self._target.position, self._rotation)
        way, turn = float(np.linalg.norm(error[:3])), float(np.linalg.norm(error[3:]))
        self.left = f"{1e3 * way:.0f} mm and {math.degrees(turn):.1f} degrees from the pose"
        arrived, self._there = self._there, way < NEAR and turn < NEAR_TURN
        if self._there:
            return "" if arrived else f"there: {self.left}"
        if now - self._at < TELL:
            return ""
        self._at = now
        back = held_back(status, gate)
        return f"{self.left}{back and f', held back: {back}'}"


def held_back(status: ControlStatus, gate: str) -> str:
    """What keeps the tool from the pose, in words; empty if nothing does but its speed."""
    at_limit = [
        f"{name} at its limit ({margin:+.2g} {unit} left)"
        for name, unit, margin, active in zip(AXES, UNITS, status.margin, status.active, strict=True)
        if active
    ]
    resting = status.reason or status.state if status.state in ("waiting", "braking") else ""
    return "; ".join(filter(None, (resting, ", ".join(at_limit), at_present(gate))))


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
