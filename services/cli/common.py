"""Shared by all commands: options, the bus of a running stack, queries, refusals, and how they end."""

from __future__ import annotations

import math
import os
import shutil
import signal
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer

from services.cli import memory
from shared.parameters import Refused
from shared.topics import Query
from shared.wire.bus import Bus, NoReply
from shared.wire.client import Client, unanswered
from shared.wire.credentials import Credentials
from shared.wire.endpoint import DEFAULT_ENDPOINT as DEFAULT_ENDPOINT
from shared.wire.endpoint import BusError, NoRouter
from shared.wire.turn import Turn
from shared.wire.zenoh import ZenohBus


def _endpoint(context: typer.Context, value: str) -> str:
    """The endpoint that was named; without one, that of the only stack that this user runs for the robot."""
    source = context.get_parameter_source("connect")
    if context.resilient_parsing or source is None or source.name != "DEFAULT":
        return value
    there = [endpoint for robot, endpoint in memory.running() if robot == context.params.get("robot")]
    if len(there) != 1 or there[0] == value:
        return value
    typer.echo(f"tandem: for the stack that runs on {there[0]}; --connect names another", err=True)
    return there[0]


Robot = Annotated[
    str, typer.Option("--robot", envvar="TANDEM_ROBOT", help="First part of every key: which robot this is about.")
]
Connect = Annotated[
    str,
    typer.Option(
        "--connect",
        envvar="TANDEM_CONNECT",
        callback=_endpoint,
        help="Endpoint of the router of the running stack; if left out, of the one that you run.",
    ),
]
Router = Annotated[
    str,
    typer.Option("--connect", "--router", envvar="TANDEM_CONNECT", help="Endpoint that the stack's own router has."),
]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON document.")]
Links = Annotated[
    str | None,
    typer.Option(
        "--links",
        envvar="TANDEM_LINKS",
        help="Direct links between the processes: sockets, none, or an endpoint with {name}; if left out, sockets "
        "where the router listens on loopback.",
    ),
]
DEFAULT_ROBOT = "tiago"
CONNECT_WITHIN = 2.0  # [s]
TAKE_OVER = {"task": "To take over: tandem task abort, release if it holds something, then reset"}
"""How to end what publishes a target, where Ctrl-C in its own terminal does not."""
SILENCE = 2.0  # [s]: who waits for longer is told for what
USAGE = 2
"""Exit status of a command that was given something it cannot take."""


def refuse(text: str, status: int = USAGE) -> NoReturn:
    """Ends the command with one clear line on standard error."""
    typer.echo(f"tandem: {text}", err=True)
    raise typer.Exit(status)


def example(line: str) -> str:
    """The end of a command's help: how it is used, in a line of its own."""
    return f"\b\nExample:\n  {line}"


@contextmanager
def waiting(what: str, at_most: float = math.inf) -> Iterator[None]:
    """Says what is awaited, and what to do about it, if the block takes longer than `SILENCE`, as it may if it takes
    `at_most` [s].
    """
    if at_most <= SILENCE:
        yield
        return
    timer = threading.Timer(SILENCE, typer.echo, (f"waiting: {what}",), {"err": True})
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def working(paths: Iterable[Path]) -> AbstractContextManager[None]:
    """Says how much there is to read of a recording, if the block takes longer than `SILENCE`."""
    size = sum(path.stat().st_size for path in paths) / 1e6
    return waiting(f"{size:.0f} MB of recording are gone through, which takes time; Ctrl-C ends it")


@contextmanager
def open_bus(
    robot: str, connect: str, within: float = CONNECT_WITHIN, give_up: Callable[[], bool] = lambda: False
) -> Iterator[ZenohBus]:
    """The bus of a running stack; refuses with one line when no router answers `within` [s] or until `give_up`,
    and when the certificate is not good for what is asked.
    """
    if not robot or any(letter in robot for letter in "/*$#?"):
        refuse(f"--robot {robot!r}: wanted one chunk of a key, without / * $ # ?")
    deadline = time.monotonic() + within
    try:
        with waiting(f"the router at {connect} is to answer; after {within:g} s this ends", within):
            bus = ZenohBus(
                robot,
                connect,
                give_up=lambda: give_up() or time.monotonic() > deadline,
                credentials=Credentials.given(robot),
            )
    except NoRouter:
        refuse(f"no router at {connect}. Start a stack with: tandem up, or choose another with --connect", 1)
    except BusError as problem:
        refuse(str(problem))
    try:
        yield bus
    except BusError as problem:
        refuse(str(problem))
    finally:
        bus.close()


def ask(
    bus: Bus, query: Query, request: dict[str, Any], timeout: float = 3.0, silence: str = "", awaited: str = ""
) -> dict[str, Any]:
    """The reply of a running service within a time [s]; its refusal or silence ends the command with one line.

    ``silence`` is what that means; without it, it is found out. ``awaited`` is told if it takes long.
    """
    try:
        with waiting(awaited or f"{query.server} is to answer on {query.key}; after {timeout:g} s this says why not"):
            return Client(bus).ask(query, request, timeout)
    except NoReply:
        if silence:
            refuse(f"no answer on {query.key} within {timeout:g} s: {silence}", 1)
        refuse(unanswered(bus, query, timeout), 1)
    except Refused as problem:
        refuse(f"{query.server} refused: {problem}", 1)


def go_first(turn: Turn) -> None:
    """Refuses if somebody else publishes what this command is about to: its messages would be refused all the time."""
    who = turn.taken()
    if who:
        remedy = TAKE_OVER.get(who, "end it where it runs (Ctrl-C)")
        refuse(f"{who} publishes {turn.topic.key} and was first: nothing of this command is followed. {remedy}", 1)


def three(option: str, text: str) -> list[float]:
    """One number for all axes, or three; refuses what is neither."""
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        refuse(f"{option} {text!r}: wanted a number or three, separated by commas")
    if len(values) not in (1, 3):
        refuse(f"{option} {text!r}: wanted one number or three, got {len(values)}")
    return values * 3 if len(values) == 1 else values


def check_place(option: str, folder: Path, needed: float) -> None:
    """Refuses a folder that cannot be written or whose disk has less than `needed` [MB] left; makes nothing."""
    there = folder.absolute()
    while not there.exists():
        there = there.parent
    if not there.is_dir() or not os.access(there, os.W_OK | os.X_OK):
        why = "cannot be written" if there.is_dir() else "is no folder"
        refuse(f"{option} {folder}: {there} {why}; choose another folder")
    free = shutil.disk_usage(there).free / 1e6
    if free < needed:
        refuse(
            f"{option} {folder}: {free:.0f} MB are free there, {needed:.0f} MB wanted; make room or choose another disk"
        )


def stop_event() -> threading.Event:
    """An event that Ctrl-C, SIGTERM and SIGHUP set."""
    event = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda *_: event.set())
    return event
