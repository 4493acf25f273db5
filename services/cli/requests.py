"""Commands that ask a stack one thing: tare, task; load, hand, cover, fault, reset, which only a simulation can do."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from services.cli.common import DEFAULT_ENDPOINT, DEFAULT_ROBOT, Connect, Robot, ask, open_bus, refuse, waiting
from services.cli.listing import Listing
from services.experiment.running import set_back
from shared import topics
from shared.clock import in_words
from shared.loop.config import one_line
from shared.parameters import Refused
from shared.requests import TASK_WORDS
from shared.schema.fields import InvalidField
from shared.sim_messages import FAULT_TARGETS, FAULTS, SensorFault
from shared.spatial import GRAVITY
from shared.wire.bus import NoReply
from shared.wire.client import Client

_SIMULATED = "only a simulated robot can do this; is one running? See: tandem status"


def tare(
    duration: Annotated[float, typer.Option(min=0.1, help="How long to average [s].")] = 1.0,
    force: Annotated[bool, typer.Option("--force", help="Adopt it although it is implausible.")] = False,
    robot: Robot = DEFAULT_ROBOT,
    connect: Connect = DEFAULT_ENDPOINT,
) -> None:
    """Average the force-torque sensor while the robot is still and nothing touches it; subtract that from now on."""
    wanted, awaited = {"duration": duration, "force": force}, f"averages for {duration:g} s: nothing may touch the tool"
    with open_bus(robot, connect) as bus:
        reply = ask(bus, topics.WRENCH_TARE, wanted, timeout=duration + 3.0, awaited=awaited)
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
    command: Annotated[str, typer.Argument(help=", ".join(TASK_WORDS), autocompletion=lambda: list(TASK_WORDS))],
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
                refuse(f"hand: {one_line(problem)}" if isinstance(problem, OSError) else f"hand {script}: {problem}")
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


TARGETS = dict(zip(FAULT_TARGETS, ("the wrist's force-torque sensor", "the head's camera", "the joints"), strict=True))
KINDS = dict(
    zip(
        FAULTS,
        (
            "sends nothing",
            "repeats one value",
            "sends what is no message",
            "adds VALUE: N and Nm (ft), rad (joints), of 255 (camera); one number, or one per axis: 1,0,0,0,0,0",
            "sends everything VALUE s late",
            "works again",
        ),
        strict=True,
    )
)


def fault(
    target: Annotated[str, typer.Argument(help=f"{', '.join(TARGETS)}; lists all if left out")] = "",
    kind: Annotated[str, typer.Argument(help=", ".join(KINDS))] = "",
    value: Annotated[str, typer.Argument(help="Of a bias or a delay; see the list.")] = "",
    robot: Robot = DEFAULT_ROBOT,
    connect: Connect = DEFAULT_ENDPOINT,
) -> None:
    """Break a sensor of the simulated robot, or mend it; without arguments list what can be broken, and how."""
    if not target:
        for title, rows in (("TARGET", TARGETS), ("KIND", KINDS)):
            shown = Listing(title, "")
            for row in rows.items():
                shown.add(*row)
            Console().print(shown)
        return
    if value and kind not in ("bias", "delay"):
        refuse(f"fault {target} {kind} {value}: {kind} takes no value")
    try:
        numbers = [float(number) for number in value.split(",")] if value else None
        asked = SensorFault(target, kind, numbers[0] if numbers and len(numbers) == 1 else numbers)
    except InvalidField as problem:
        refuse(f"fault: {problem}")
    except ValueError:
        refuse(f"fault: value {value!r}: wanted a number, or one per axis separated by commas")
    _command(robot, connect, {"command": "fault", **asked.to_plain()})
    typer.echo(f"{TARGETS[target]}: {KINDS[kind].replace('VALUE', value, 1).partition(':')[0]}")


def reset(robot: Robot = DEFAULT_ROBOT, connect: Connect = DEFAULT_ENDPOINT) -> None:
    """Set the simulated scene back for another carry: robot, panel, person, faults, and the task. Tare afterwards."""
    with open_bus(robot, connect) as bus:
        try:
            with waiting("the task is to see an empty gripper and the robot's new session, which takes up to 10 s"):
                set_back(Client(bus))
        except NoReply as problem:
            refuse(f"{problem}: {_SIMULATED}", 1)
        except Refused as problem:
            refuse(f"the scene is set back, but not the task: {problem}", 1)
    typer.echo("the scene is as it was at the start")


def _command(robot: str, connect: str, request: dict[str, Any]) -> None:
    with open_bus(robot, connect) as bus:
        ask(bus, topics.SIM_COMMAND, request, silence=_SIMULATED)
