"""The command `tandem`."""

from __future__ import annotations

import sys

import typer

from services.cli import actions, param, run, simulated, topic
from services.cli.certify import CONTEXT, certify
from services.cli.identify import identify
from services.cli.refusal import USAGE
from services.cli.status import status
from services.cli.up import start, up

NUMBERS = {"ignore_unknown_options": True}  # so that -0.3 is a number, not an option

commands = typer.Typer(
    help="Force-safe carrying with a robot: start a stack, watch it, speak to it, play experiments.",
    add_completion=False,
    pretty_exceptions_enable=False,
)
commands.command()(up)
commands.command()(start)
commands.add_typer(run.app, name="run")
commands.command()(status)
commands.add_typer(topic.app, name="topic")
commands.add_typer(param.app, name="param")
commands.command()(actions.stop)
commands.command()(actions.resume)
commands.command()(actions.tare)
commands.command()(actions.task)
commands.command()(identify)
commands.command(context_settings=NUMBERS)(actions.hold)
commands.command(context_settings=NUMBERS)(simulated.load)
commands.command(context_settings=NUMBERS)(simulated.hand)
commands.command()(simulated.cover)
commands.command(context_settings=CONTEXT)(certify)


def app() -> None:
    """Runs a command; what it cannot take is refused with one line and exit status 2."""
    try:
        sys.exit(commands(sys.argv[1:] or ["--help"], prog_name="tandem", standalone_mode=False))
    except typer.Abort:
        typer.echo("tandem: aborted", err=True)
        sys.exit(1)
    except typer.TyperException as problem:
        context = getattr(problem, "ctx", None)
        path = context.command_path if context else "tandem"
        reason = problem.format_message() if hasattr(problem, "format_message") else str(problem)
        typer.echo(f"tandem: {reason} See: {path} --help", err=True)
        sys.exit(USAGE)
