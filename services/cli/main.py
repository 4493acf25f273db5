"""The command `tandem`."""

from __future__ import annotations

import platform
import sys
from collections.abc import Sequence
from importlib.metadata import version
from typing import Annotated, NoReturn

import typer

from services.cli import param, requests, run, topic
from services.cli.certify import certify
from services.cli.check_robot import check_robot
from services.cli.common import USAGE, example
from services.cli.doctor import doctor
from services.cli.enable import enable
from services.cli.hold import hold
from services.cli.identify import identify
from services.cli.keys import keys
from services.cli.record import export, record
from services.cli.replay import replay_
from services.cli.status import status
from services.cli.stop import resume, stop
from services.cli.top import top
from services.cli.up import start, up
from services.cli.view import view

NUMBERS = {"ignore_unknown_options": True}  # so that -0.3 is a number, not an option


def _version(asked: bool) -> None:
    if asked:
        typer.echo(f"tandem {version('tandem')}, Python {platform.python_version()}")
        raise typer.Exit


commands = typer.Typer(
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    rich_markup_mode=None,  # which would take a unit in brackets for its own mark
)


@commands.callback()
def root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    """Force-safe carrying with a robot: start a stack, watch it, speak to it, play experiments."""


commands.command(epilog=example("tandem up --with base"))(up)
commands.command(epilog=example("tandem start controller"))(start)
commands.add_typer(run.app, name="run")
commands.command(epilog=example("tandem status --json"))(status)
commands.add_typer(topic.app, name="topic")
commands.add_typer(param.app, name="param")
commands.command(epilog=example("tandem stop 'a child runs in'"))(stop)
commands.command(epilog=example("tandem resume"))(resume)
commands.command(epilog=example("tandem enable"))(enable)
commands.command(epilog=example("tandem tare --duration 2"))(requests.tare)
commands.command(epilog=example("tandem task start"))(requests.task)
commands.command(epilog=example("tandem identify --angle 0.5"))(identify)
commands.command(context_settings=NUMBERS, epilog=example("tandem hold 0.5 -0.3 1 0 0 0 --force-limit 25"))(hold)
commands.command(context_settings=NUMBERS, epilog=example("tandem load 20"))(requests.load)
commands.command(context_settings=NUMBERS, epilog=example("tandem hand 1.74 -0.39 0.93"))(requests.hand)
commands.command(epilog=example("tandem cover --off"))(requests.cover)
commands.command(context_settings=NUMBERS, epilog=example("tandem fault ft bias 0,0,9,0,0,0"))(requests.fault)
commands.command(epilog=example("tandem reset"))(requests.reset)
commands.command(epilog=example("tandem certify --force-limit 10,10,25"))(certify)
commands.command("check-robot", epilog=example("tandem check-robot --move"))(check_robot)
commands.command(epilog=example("tandem doctor --json"))(doctor)
commands.command(epilog=example("tandem top --once"))(top)
commands.command(epilog=example("tandem keys keys --name 192.0.2.7"))(keys)
commands.command(epilog=example("tandem record --no-camera --most 500"))(record)
commands.command(epilog=example("tandem export runs/record --csv tables"))(export)
commands.command(epilog=example("tandem view runs/carry-20261130-090000/certified-omni"))(view)
commands.command("replay", epilog=example("tandem replay runs/load/certified-100 --into controller"))(replay_)


def app(arguments: Sequence[str] | None = None) -> NoReturn:
    """Runs a command; what it cannot take is refused with one line and exit status 2."""
    given = sys.argv[1:] if arguments is None else list(arguments)
    try:
        sys.exit(commands(given or ["--help"], prog_name="tandem", standalone_mode=False))
    except typer.Abort:
        typer.echo("tandem: aborted", err=True)
        sys.exit(1)
    except typer.TyperException as problem:
        context = getattr(problem, "ctx", None)
        path = context.command_path if context else "tandem"
        reason = problem.format_message() if hasattr(problem, "format_message") else str(problem)
        typer.echo(f"tandem: {reason} See: {path} --help", err=True)
        sys.exit(USAGE)
