"""The command `tandem`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import NoReturn

import typer

from services.cli import param, requests, run, topic
from services.cli.certify import certify
from services.cli.common import USAGE
from services.cli.hold import hold
from services.cli.identify import identify
from services.cli.keys import keys
from services.cli.record import export, record
from services.cli.status import status
from services.cli.stop import resume, stop
from services.cli.up import start, up

NUMBERS = {"ignore_unknown_options": True}  # so that -0.3 is a number, not an option

commands = typer.Typer(
    help="Force-safe carrying with a robot: start a stack, watch it, speak to it, play experiments.",
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # which would take a unit in brackets for its own mark
)
commands.command()(up)
commands.command()(start)
commands.add_typer(run.app, name="run")
commands.command()(status)
commands.add_typer(topic.app, name="topic")
commands.add_typer(param.app, name="param")
commands.command()(stop)
commands.command()(resume)
commands.command()(requests.tare)
commands.command()(requests.task)
commands.command()(identify)
commands.command(context_settings=NUMBERS)(hold)
commands.command(context_settings=NUMBERS)(requests.load)
commands.command(context_settings=NUMBERS)(requests.hand)
commands.command()(requests.cover)
commands.command(context_settings=NUMBERS)(requests.fault)
commands.command()(requests.reset)
commands.command()(certify)
commands.command()(keys)
commands.command()(record)
commands.command()(export)


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
