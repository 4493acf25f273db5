"""`tandem check-robot`: whether a robot process keeps the contract, key by key, for any robot, simulated or real.

Without ``--move`` it only listens, and weighs. With it, it says first what it will do to the robot, and waits for the
person's consent.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Annotated, Any

import typer

from services.cli.check import disturbing, gating, listening, moving, weighing
from services.cli.check.bench import Bench
from services.cli.check.heard import ALWAYS, Robot
from services.cli.check.rows import Row, judged
from services.cli.common import DEFAULT_ENDPOINT, DEFAULT_ROBOT, AsJson, Connect, ask, open_bus, refuse
from services.cli.common import Robot as Name
from services.cli.listing import show_json
from shared.processes import ROBOTS
from shared.robot.side import at_present
from shared.topics import (
    COMMAND_BASE_TWIST,
    COMMAND_EE_TWIST,
    COMMAND_GRIPPER,
    ROBOT,
    SENSOR_CAMERA,
    SENSOR_FT,
    SIM_COMMAND,
    SIM_WORLD,
    health_topic,
)
from shared.wire.client import forbidden
from shared.wire.zenoh import ZenohBus

COMMANDS = (COMMAND_EE_TWIST, COMMAND_BASE_TWIST, COMMAND_GRIPPER)
"""Topics whose publishers command the robot."""
HUNG = 1.0  # [kg] that is hung from a simulated tool
GONE_WITHIN = 5.0  # [s] after which the weight is taken off again
CAMERA_WITHIN = 8.0  # [s] after which a camera counts as none: what renders a simulated picture has to start
HEALTH_WITHIN = 1.5  # [s] until its health is heard, told twice a second
FOUND_WITHIN = 1.0  # [s] until others' tokens are seen
MOVES = (
    f"The tool will move {1e3 * moving.WAY:g} mm along and {moving.ANGLE:g} rad about each axis, forth and back, at "
    f"{moving.SPEED:g} m/s and {moving.TURN:g} rad/s, and sway by {1e3 * moving.SPEED * 0.5:g} mm. Then come commands "
    "that the robot has to refuse, and a stop that is released again. A robot that does not tell where it is may go "
    f"{1e3 * moving.SPEED * moving.PATIENCE:g} mm."
)
BASE_MOVES = f"The base will move {1e3 * moving.WAY:g} mm and {moving.ANGLE:g} rad or a little more, forth and back."
CARE = (
    "Where the robot asks for an enabling device, hold that all the while (tandem enable). Have the emergency stop at "
    "hand. Nobody and nothing may be near the arm, and it needs room on every side."
)


def check_robot(
    move: Annotated[bool, typer.Option("--move", help="Command the tool, a centimetre each way; asks first.")] = False,
    base: Annotated[bool, typer.Option("--base", help="With --move: the base, too.")] = False,
    disturb: Annotated[
        str,
        typer.Option(help=f"With --move: {', '.join(disturbing.ASKED)}, several with commas; you are told what to do."),
    ] = "",
    weight: Annotated[
        float, typer.Option(min=0.0, max=20.0, help="Mass [kg] that you will hang from the tool, when asked; 0 = none.")
    ] = 0.0,
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask before moving.")] = False,
    robot: Name = DEFAULT_ROBOT,
    connect: Connect = DEFAULT_ENDPOINT,
    as_json: AsJson = False,
) -> None:
    """Check any robot process: its keys, rates, signs and frames, and with --move what its gate lets through."""
    if base and not move:
        refuse("--base moves the base: it needs --move")
    names = [name for name in disturb.split(",") if name]
    if strange := [name for name in names if name not in disturbing.ASKED]:
        refuse(f"--disturb {strange[0]}: wanted {', '.join(disturbing.ASKED)}")
    if names and not move:
        refuse("--disturb has the tool move: it needs --move")
    rows: list[Row] = []
    with open_bus(robot, connect) as bus:
        for row in _rows(bus, move, base, names, weight, yes):
            rows.append(row)
            if not as_json:
                typer.echo(str(row))
    wrong = [row for row in rows if row.good is False]
    if as_json:
        checks = [{"what": row.what, "good": row.good, "said": row.said} for row in rows]
        show_json({"good": not wrong, "checks": checks})
    else:
        tried = sum(row.good is not None for row in rows)
        typer.echo(f"{len(wrong)} of {tried} wrong" if wrong else f"all {tried} ok")
    if wrong:
        raise typer.Exit(1)


def _rows(bus: ZenohBus, move: bool, base: bool, disturb: Sequence[str], weight: float, yes: bool) -> Iterator[Row]:
    bench, health = Bench(bus), Robot()
    for name in ROBOTS:
        bus.subscribe(health_topic(name).key, partial(health.take, health_topic(name).key))
    missing = list(listening.missing(bench))
    yield from missing
    if len(missing) == len(ALWAYS):
        yield Row("robot", False, "nothing is heard of it: is its process running, under this --robot and --connect?")
        return
    bench.wait(listening.LISTENED)
    yield from listening.publications(bench.robot)
    yield from listening.contents(bench.robot)
    yield _alive(bus, bench)
    yield from _health(bench, health)
    yield _camera(bus, bench)
    if SENSOR_FT.key in bench.robot.heard:
        yield from _weight(bus, bench, weight)
    if not move:
        yield Row("motion", None, "not tried: with --move the tool moves a centimetre each way, and the gate is tried")
    elif missing:
        yield Row("motion", False, "not tried: what is missing above comes first")
    else:
        yield from _moved(bus, bench, base, disturb, yes)


def _alive(bus: ZenohBus, bench: Bench) -> Row:
    """Whether the process holds its liveliness token."""
    if bench.within(FOUND_WITHIN, lambda: bus.living() & set(ROBOTS)):
        return Row("alive", True, f"alive/{', '.join(sorted(bus.living() & set(ROBOTS)))}")
    return Row("alive", False, f"no liveliness token alive/{ROBOT}: who waits for the robot sees none")


def _health(bench: Bench, heard: Robot) -> Iterator[Row]:
    """What the process says of itself."""
    bench.within(HEALTH_WITHIN, lambda: heard.heard)
    if not heard.heard:
        yield Row("health", False, f"no health/{ROBOT}: nobody is told what the process lacks; 2 Hz (docs/contract.md)")
    for key, told in heard.heard.items():
        health: Any = told[-1].message
        yield judged(key, f"{health.state}: {health.detail}" if health.state != "ok" else "", "ok, by its own account")


def _camera(bus: ZenohBus, bench: Bench) -> Row:
    robot = bench.robot
    leave = bus.listen(SENSOR_CAMERA.key, partial(robot.take, SENSOR_CAMERA.key))
    bench.within(CAMERA_WITHIN, lambda: len(robot.all(SENSOR_CAMERA)) > 2)
    leave()
    pictures = robot.all(SENSOR_CAMERA)
    unread = [text for text in list(robot.rejected) if text.startswith(SENSOR_CAMERA.key)]
    if unread:
        return Row(SENSOR_CAMERA.key, False, unread[-1].partition(": ")[2])
    if not pictures:
        return Row(SENSOR_CAMERA.key, None, "not heard; optional: only the carrying task looks at it")
    picture: Any = pictures[-1].message
    right = f"{picture.width} x {picture.height}, {picture.encoding}"
    return judged(SENSOR_CAMERA.key, listening.header_fault(pictures), right)


def _weight(bus: ZenohBus, bench: Bench, weight: float) -> Iterator[Row]:
    """Hang a weight, or have a person hang it."""
    world: list[Any] = [one.message for one in bench.robot.all(SIM_WORLD)]
    if world and world[-1].bag is not None:
        yield Row("weight", None, "not tried: a bag hangs there; take it off first: tandem load 0")
        return
    if not world and not weight:
        yield Row("weight", None, "not tried: with --weight KG you are asked to hang a known mass from the tool")
        return
    before, mass = weighing.wrench_in_base(bench.robot), weight or HUNG
    if world:
        ask(bus, SIM_COMMAND, {"command": "load", "mass": mass})
    else:
        typer.confirm(f"Hang {mass:g} kg from the tool's origin. Does it hang still?", abort=True, err=True)
    yield weighing.weighed(bench, before, mass)
    if world:
        ask(bus, SIM_COMMAND, {"command": "load", "mass": 0.0})
        last = bench.robot.all
        bench.within(GONE_WITHIN, lambda: last(SIM_WORLD)[-1].message.bag is None)  # type: ignore[attr-defined]
    else:
        typer.confirm("Take it off again. Is it off?", abort=True, err=True)


def _moved(bus: ZenohBus, bench: Bench, base: bool, disturb: Sequence[str], yes: bool) -> Iterator[Row]:
    """Command it, if nobody else does and the person agrees."""
    status = bench.robot.status
    commanders = sorted(bus.living() & {name for topic in COMMANDS for name in topic.publishers})
    if commanders:
        yield Row("motion", False, f"not tried: {', '.join(commanders)} runs and commands the robot; end it first")
        return
    for topic in (COMMAND_EE_TWIST, *((COMMAND_BASE_TWIST,) if base else ())):
        if why := forbidden(topic):
            yield Row("motion", False, f"not tried: {why}")
            return
    if status.mode == "stopped":
        yield Row("motion", False, f"not tried: it is stopped ({at_present(status.reason)}); release it: tandem resume")
        return
    typer.echo("\n".join((MOVES, *((BASE_MOVES,) if base else ()), CARE)), err=True)
    if not yes:
        typer.confirm("Move now?", abort=True, err=True)
    first = bench.commander()
    yield from moving.tool_moves(bench, first)
    yield from gating.Gates(bench, first, bench.commander()).rows()
    if base:
        yield from moving.base_moves(bench, bench.commander(COMMAND_BASE_TWIST))
    yield from disturbing.Disturbances(bench, first, partial(typer.echo, err=True)).rows(disturb)
