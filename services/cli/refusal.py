"""How a command says no: one line on standard error and an exit status."""

from __future__ import annotations

from typing import NoReturn

import typer

USAGE = 2  # exit status of a command that was given something it cannot take


def refuse(text: str, status: int = USAGE) -> NoReturn:
    """Ends the command with one clear line."""
    typer.echo(f"tandem: {text}", err=True)
    raise typer.Exit(status)
