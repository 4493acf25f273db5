"""`tandem view`: the robot, its forces and limits in a browser, live or recorded."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Annotated

import typer

from services.cli.common import DEFAULT_ENDPOINT, DEFAULT_ROBOT, Connect, Robot, refuse
from services.cli.ports import PAGE
from services.cli.stack.page import free_pair
from shared.processes import process_named


def view(
    recording: Annotated[
        Path | None, typer.Argument(help="A recording (.mcap) or a folder of them, instead of the running robot.")
    ] = None,
    beside: Annotated[
        Path | None,
        typer.Option(help="Another recording on its right, such as what a replay with a change has written."),
    ] = None,
    port: Annotated[
        int | None,
        typer.Option(
            help=f"Of the page, on this machine alone; 0: any. Left out: {PAGE}, or the next one where that is taken.",
            min=0,
            max=65534,
        ),
    ] = None,
    native: Annotated[bool, typer.Option("--native", help="In rerun's own viewer; all ends with its window.")] = False,
    browser: Annotated[bool, typer.Option("--open/--no-open", help="Open the page where there is a desktop.")] = True,
    robot: Robot = DEFAULT_ROBOT,
    connect: Connect = DEFAULT_ENDPOINT,
) -> None:
    """Show what a robot does and why, in a browser, until Ctrl-C."""
    if beside is not None and recording is None:
        refuse(f"--beside {beside}: beside which recording? tandem view RECORDING --beside {beside}")
    for place in (recording, beside):
        if place is not None and not place.exists():
            refuse(f"{place}: not there; wanted a recording (.mcap) or a folder of them")
    port = port if port is not None else free_pair() or PAGE
    command = [sys.executable, "-m", process_named("viewer").module, "--robot", robot, "--connect", connect]
    command += ["--port", str(port), *(["--recording", str(recording)] if recording else [])]
    command += ["--beside", str(beside)] if beside else []
    command += [*(["--native"] if native else []), *(["--open"] if browser and not native else [])]
    # The viewer itself from here on: signals and exit status are its own.
    os.execv(command[0], command)
