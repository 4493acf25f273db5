"""Commands that ask a stack one thing: tare, task; and load, hand, cover, which only a simulated robot can do."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any

import typer

from services.cli.common import DEFAULT_ENDPOINT, DEFAULT_ROBOT, Connect, Robot, ask, open_bus, refuse
from shared import topics
from shared.clock import in_words
from shared.spatial import GRAVITY


def tare(
    duration: Annotated[float, typer.Option(min=0.1, help="How long to average [s].")] = 1.0,
    force: Annotated[bool, typer.Option("--force", help="Adopt it although it is implausible.")] = False,
    robot: Robot = DEFAULT_ROBOT,
    connect: Connect = DEFAULT_ENDPOINT,
) -> None:
    """Average the force-torque sensor while the robot is still and nothing touches it; subtract that from now on."""
    with open_bus(robot, connect) as bus:
        reply = ask(bus, topics.WRENCH_TARE, {"duration": duration, "force": force}, timeout=duration + 3.0)
    before = reply.get("replaced_age", -1.0)
    replaced = f"; the zero before was {in_words(before)} old" if before >= 0.0 else ""
    typer.echo(f"tared over {reply['samples']} samples (sensor axes){replaced}")
    for name, unit, bias, std in (
        ("force", "N", reply["force"], reply["std"][:3]),
        ("torque", "Nm", reply["torque"], reply["std"][3:]),
    ):
        shown = ", ".join(f"{value:+.3f} ± {spread:.3f}" for value, spread in zip(bias, std, strict=True))
        typer.echo(f"{name:6} [{shown}] {unit}")
    typer.echo("That nothing touched the tool is your word: a steady push within bias_bound looks like a bias.")
    if reply.get("warning"):
        typer.echo(f"adopted by force: {reply['warning']}", err=True)


def task(
    command: Annotated[str, typer.Argument(help="start, abort, release or reset")],
    robot: Robot = DEFAULT_ROBOT,
    connect: Connect = DEFAULT_ENDPOINT,
) -> None:
    """Tell the carrying task what to do; `tandem topic echo task/status` says what it does and why."""
    with open_bus(robot, connect) as bus:
        reply = ask(bus, topics.TASK_COMMAND, {"command": command})
    typer.echo(f"{command}: accepted, the task is {reply['state']}; what it does: tandem topic echo task/status")


def load(
    weight: Annotated[float, typer.Argument(min=0.0, help="Weight of the bag [N]; 0 takes it off.")],
    robot: Robot = DEFAULT_ROBOT,
    connect: Connect = DEFAULT_ENDPOINT,
) -> None:
    """Hang a bag from the simulated robot's tool."""
    _command(robot, connect, {"command": "load", "mass": weight / GRAVITY})
    typer.echo(f"a bag of {weight:g} N hangs from the tool" if weight else "the bag is off")


def hand(
    where: Annotated[
        list[str],
        typer.Argument(
            help="X Y Z [m] to guide the hands to, in base_footprint as it stood at the start; or: carry; or a script "
            "in TOML, as a file or as text"
        ),
    ],
    robot: Robot = DEFAULT_ROBOT,
    connect: Connect = DEFAULT_ENDPOINT,
) -> None:
    """Have the simulated person guide the panel's far end somewhere, or play the whole carry or a script."""
    if len(where) == 1:
        script, text = where[0], where[0]
        if script.endswith(".toml"):
            try:
                text = Path(script).read_text(encoding="utf-8")
            except (OSError, UnicodeDecodeError) as problem:
                refuse(f"hand {script}: {problem}")
        _command(robot, connect, {"command": "hand", "script": text})
        typer.echo(f"the person plays {script if script.isidentifier() else 'your script'}")
        return
    try:
        target = [float(number) for number in where]
    except ValueError:
        target = []
    if len(target) != 3 or not all(map(math.isfinite, target)):
        refuse(f"hand {' '.join(where)}: wanted X Y Z in m, carry, or a script (FILE.toml, or its text)")
    _command(robot, connect, {"command": "hand", "target": target})
    typer.echo(f"the hands go to {target} m, at 0.15 m/s")


def cover(
    off: Annotated[bool, typer.Option("--off", help="Take it off again.")] = False,
    robot: Robot = DEFAULT_ROBOT,
    connect: Connect = DEFAULT_ENDPOINT,
) -> None:
    """Put something over the simulated panel's marker, or take it off."""
    _command(robot, connect, {"command": "cover_marker", "covered": not off})
    typer.echo(f"the marker is {'uncovered' if off else 'covered'}")


def _command(robot: str, connect: str, request: dict[str, Any]) -> None:
    with open_bus(robot, connect) as bus:
        ask(bus, topics.SIM_COMMAND, request)
