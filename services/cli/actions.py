"""Commands that act on a running stack: stop, resume, tare, task, hold."""

from __future__ import annotations

import time
from typing import Annotated

import numpy as np
import typer

from services.cli.ask import ask
from services.cli.common import DEFAULT_ENDPOINT, DEFAULT_ROBOT, Connect, Robot, open_bus
from services.cli.health.diagnose import control_line
from services.cli.interrupt import stop_event
from services.cli.refusal import refuse
from shared import topics
from shared.messages import ControlStatus, ControlTarget, RobotStatus, Stop
from shared.schema.fields import InvalidField
from shared.spatial import quaternion_from_rpy
from shared.wire.bus import Bus
from shared.wire.client import Client
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
    robot_status: Subscription[RobotStatus] = client.watch(topics.STATE_ROBOT)
    controller: Subscription[ControlStatus] = client.watch(topics.CONTROL_STATUS)
    deadline = time.monotonic() + CONFIRM_WITHIN
    latched = False
    while time.monotonic() < deadline:
        client.publish(topics.STOP, message)
        time.sleep(REPEAT)
        shown = robot_status.latest
        latched = (
            not message.engaged
            and controller.latest is not None
            and "latched" in controller.latest.message.reason
        )
        if shown is not None and (shown.message.mode == "stopped") == message.engaged and not latched:
            return
    if robot_status.latest is None:
        refuse(
            "sent, but no robot answers on state/robot: is the robot process running? See: tandem status", 1
        )
    if latched:
        assert controller.latest is not None
        refuse(f"the robot is released, but not the controller: {controller.latest.message.reason}", 1)
    wanted = "stopped" if message.engaged else "released"
    mode = robot_status.latest.message.mode
    refuse(f"sent, but the robot does not show {wanted} within {CONFIRM_WITHIN:g} s (it is {mode})", 1)


def tare(
    duration: Annotated[float, typer.Option(min=0.1, help="How long to average [s].")] = 1.0,
    robot: Robot = DEFAULT_ROBOT,
    connect: Connect = DEFAULT_ENDPOINT,
) -> None:
    """Average the force-torque sensor while the robot is still and subtract that from now on."""
    with open_bus(robot, connect) as bus:
        reply = ask(bus, topics.WRENCH_TARE, {"duration": duration}, timeout=duration + 3.0)
    typer.echo(f"tared over {reply['samples']} samples (sensor axes)")
    for name, unit, bias, std in (
        ("force", "N", reply["force"], reply["std"][:3]),
        ("torque", "Nm", reply["torque"], reply["std"][3:]),
    ):
        shown = ", ".join(f"{value:+.3f} ± {spread:.3f}" for value, spread in zip(bias, std, strict=True))
        typer.echo(f"{name:6} [{shown}] {unit}")


def task(
    command: Annotated[str, typer.Argument(help="start, abort, release or reset")],
    robot: Robot = DEFAULT_ROBOT,
    connect: Connect = DEFAULT_ENDPOINT,
) -> None:
    """Tell the carrying task what to do; `tandem topic echo task/status` says what it does and why."""
    with open_bus(robot, connect) as bus:
        reply = ask(bus, topics.TASK_COMMAND, {"command": command})
    typer.echo(
        f"{command}: accepted, the task is {reply['state']}; what it does: tandem topic echo task/status"
    )


def hold(
    pose: Annotated[list[float], typer.Argument(help="X Y Z [m] ROLL PITCH YAW [rad] of the tool in base.")],
    force_limit: Annotated[str, typer.Option(help="Largest force [N]: one number, or x,y,z.")] = "25",
    torque_limit: Annotated[str, typer.Option(help="Largest torque [Nm]: one number, or x,y,z.")] = "10",
    robot: Robot = DEFAULT_ROBOT,
    connect: Connect = DEFAULT_ENDPOINT,
) -> None:
    """Have the robot hold a pose within limits, until Ctrl-C (the last target then stays in force). Tare first."""
    target = make_target(pose, limits("--force-limit", force_limit), limits("--torque-limit", torque_limit))
    with open_bus(robot, connect) as bus:
        client = Client(bus)
        status = client.watch(topics.CONTROL_STATUS)
        typer.echo(f"holding {pose} with {force_limit} N, {torque_limit} Nm (Ctrl-C ends this command)")
        end, shown = stop_event(), ""
        while not end.wait(REPEAT):
            client.publish(topics.CONTROL_TARGET, target)
            line = control_line(status.latest.message if status.latest else None)[0]
            if line.split(":")[0] != shown:
                shown = line.split(":")[0]
                typer.echo(f"controller: {line}")
    typer.echo("the last target stays in force")


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


def limits(option: str, text: str) -> list[float]:
    """One number for all axes, or three."""
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        refuse(f"{option} {text!r}: wanted a number or three, separated by commas")
    if len(values) not in (1, 3):
        refuse(f"{option} {text!r}: wanted one number or three, got {len(values)}")
    return values * 3 if len(values) == 1 else values
