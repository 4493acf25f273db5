"""`tandem identify`: the payload beyond the sensor, from the forces in several orientations of the tool."""

from __future__ import annotations

import math
import time
from typing import Annotated, Any

import numpy as np
import typer

from services.cli.common import (
    DEFAULT_ENDPOINT,
    DEFAULT_ROBOT,
    Connect,
    Robot,
    ask,
    go_first,
    open_bus,
    refuse,
    three,
)
from services.cli.hold import REPEAT, TELL, make_target
from shared import topics
from shared.messages import ControlTarget, EndEffector, RobotStatus
from shared.parameters import Refused
from shared.spatial import pose_error, rotation_matrix, rpy_from_rotation
from shared.wire.bus import NoReply
from shared.wire.client import Client, forbidden, unheard
from shared.wire.subscription import Subscription
from shared.wire.turn import Turn
from shared.wire.zenoh import ZenohBus

TILTS = ((0, 0), (1, 0), (0.7, 0.7), (0, 1), (-0.7, 0.7), (-1, 0), (-0.7, -0.7), (0, -1), (0.7, -0.7), (0, 0))
"""Tilts about base x and y as shares of the angle: once around, each a short way from the last."""
STILL = 0.003  # [m/s], [rad/s]: a slower tool counts as still
STILL_FOR = 1.0  # [s]
GIVEN_UP_AFTER = 4.0  # [s] of standing still far from the pose: a joint is at its end
ATTEMPTS = 4  # at one measurement, which a hiccup may spoil
AVERAGED = 1.5  # [s] that the wrench service may take for one pose
REACH_WITHIN = 60.0  # [s] per pose
ARRIVED = 0.15  # [rad]: the pose itself does not matter, only that the orientations differ


def identify(
    angle: Annotated[float, typer.Option(min=0.1, max=1.2, help="How far to tilt the tool [rad].")] = 0.6,
    force_limit: Annotated[str, typer.Option(help="Force limit on the way [N].")] = "60",
    torque_limit: Annotated[str, typer.Option(help="Torque limit on the way [Nm].")] = "15",
    force: Annotated[bool, typer.Option("--force", help="Adopt it although it is implausible.")] = False,
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask before moving.")] = False,
    robot: Robot = DEFAULT_ROBOT,
    connect: Connect = DEFAULT_ENDPOINT,
) -> None:
    """Identify mass, centre of mass and sensor biases: tilts the tool about its present position, ten poses."""
    limits = three("--force-limit", force_limit), three("--torque-limit", torque_limit)
    with open_bus(robot, connect) as bus:
        if why := forbidden(topics.CONTROL_TARGET):
            refuse(why)
        client = Client(bus, name="identify")
        turn = client.publisher.share(topics.CONTROL_TARGET)
        subscription, status = client.watch(topics.STATE_EE), client.watch(topics.STATE_ROBOT)
        start = _first(subscription)
        while not turn.listened:
            go_first(turn)
            time.sleep(REPEAT)
        roll, pitch, yaw = rpy_from_rotation(rotation_matrix(start.orientation))
        typer.echo(f"The tool stays near {np.round(start.position, 2).tolist()} m and tilts up to {angle:g} rad.")
        typer.echo("Nothing may touch it, and nothing but its payload may hang from it.")
        if not yes:
            typer.confirm("Move now?", abort=True)
        typer.echo("taring: nothing may touch the tool")
        # Before a tare the error bound holds the whole weight, and the controller would hardly dare to turn.
        _measure(client, topics.WRENCH_TARE, {"duration": 1.0, "force": force})
        ask(bus, topics.WRENCH_IDENTIFY, {"action": "start"})
        try:
            for number, (about_x, about_y) in enumerate(TILTS, 1):
                pose = [*start.position.tolist(), roll + about_x * angle, pitch + about_y * angle, yaw]
                typer.echo(f"pose {number} of {len(TILTS)} ", nl=False)
                away = _go(client, turn, subscription, make_target(pose, *limits))
                _measure(client, topics.WRENCH_IDENTIFY, {"action": "add"})
                typer.echo("taken" if away < ARRIVED else _short(away, status))
            reply = ask(bus, topics.WRENCH_IDENTIFY, {"action": "solve", "force": force})
        except (KeyboardInterrupt, typer.Exit):
            _cancel(bus)
            raise
    _show(reply)
    typer.echo(f"The tool is back; the last target, with {force_limit} N and {torque_limit} Nm, stays in force.")


def _first(subscription: Subscription[EndEffector]) -> EndEffector:
    deadline = time.monotonic() + 2.0
    while time.monotonic() < deadline:
        latest = subscription.latest
        if latest is not None:
            return latest.message
        time.sleep(0.02)
    refuse(unheard(subscription), 1)


def _measure(client: Client, query: topics.Query, request: dict[str, Any]) -> None:
    """Has the wrench service average; a hiccup of sensor or machine spoils a measurement, not the identification."""
    for attempt in range(1, ATTEMPTS + 1):
        try:
            client.ask(query, request, timeout=AVERAGED + 3.0)
            return
        except (NoReply, Refused) as problem:
            if attempt == ATTEMPTS:
                refuse(f"{query.key} failed {ATTEMPTS} times: {problem}", 1)


def _go(client: Client, turn: Turn, subscription: Subscription[EndEffector], target: ControlTarget) -> float:
    """Repeats the target until the tool is still, near it or where its joints end; returns the angle left [rad]."""
    deadline = time.monotonic() + REACH_WITHIN
    still_since, told = None, time.monotonic()
    while time.monotonic() < deadline:
        go_first(turn)
        if turn.listened:
            client.publish(topics.CONTROL_TARGET, target)
        time.sleep(REPEAT)
        assert subscription.latest is not None
        tool = subscription.latest.message
        stands, wanted = rotation_matrix(tool.orientation), rotation_matrix(target.orientation)
        error = pose_error(tool.position, stands, target.position, wanted)
        moving = max(np.linalg.norm(tool.linear), np.linalg.norm(tool.angular)) > STILL
        away = float(np.linalg.norm(error[3:]))
        if time.monotonic() - told > TELL:
            told = time.monotonic()
            typer.echo(f"({math.degrees(away):.0f} degrees left) ", nl=False)
        if moving:
            still_since = None
        elif still_since is None:
            still_since = time.monotonic()
        elif time.monotonic() - still_since > (STILL_FOR if away < ARRIVED else GIVEN_UP_AFTER):
            return away
    refuse(
        f"not reached within {REACH_WITHIN:g} s ({math.degrees(away):.0f} degrees away): tilt less with --angle; "
        "see: tandem status",
        1,
    )


def _short(away: float, status: Subscription[RobotStatus]) -> str:
    """How far [rad] a pose was missed, and what the robot says about it: other orientations do as well."""
    reason = status.latest.message.reason if status.latest else ""
    return f"taken {math.degrees(away):.0f} degrees short of it{reason and f' ({reason})'}"


def _cancel(bus: ZenohBus) -> None:
    typer.echo("cancelled: the present compensation stays")
    ask(bus, topics.WRENCH_IDENTIFY, {"action": "cancel"})


def _show(reply: dict[str, Any]) -> None:
    sigma = reply["sigma"]
    typer.echo(f"mass            {reply['mass']:.4f} ± {sigma[0]:.4f} kg (± one standard deviation)")
    for name, values, spreads, scale, digits, unit in (
        ("centre of mass", reply["com"], sigma[1:4], 1e3, 1, "mm from the sensor, sensor axes"),
        ("force bias", reply["force_bias"], sigma[4:7], 1.0, 3, "N"),
        ("torque bias", reply["torque_bias"], sigma[7:], 1.0, 4, "Nm"),
    ):
        shown = ", ".join(
            f"{scale * value:+.{digits}f} ± {scale * spread:.{digits}f}"
            for value, spread in zip(values, spreads, strict=True)
        )
        typer.echo(f"{name:15} [{shown}] {unit}")
    typer.echo(f"residual (rms)  [{', '.join(f'{value:.3f}' for value in reply['residual_rms'])}] N, Nm")
    typer.echo(f"condition       {reply['condition']:.1f}")
    typer.echo("It is subtracted from now on, in every pose; the farther from the ten, the larger the stated error.")
    if reply.get("warning"):
        typer.echo(f"adopted by force: {reply['warning']}", err=True)
    if reply.get("file"):
        typer.echo(f"A later stack uses it too with: tandem up --set 'wrench.payload=\"{reply['file']}\"'")
