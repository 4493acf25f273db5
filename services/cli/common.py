"""Shared by all commands: options, the bus of a running stack, queries, refusals, and how they end."""

from __future__ import annotations

import math
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Annotated, Any, Literal, NoReturn

import typer
from rich.table import Table

from shared.faults import FaultKind
from shared.parameters import Refused
from shared.processes import speakers
from shared.topics import Query
from shared.wire.bus import Bus, NoReply
from shared.wire.client import Client
from shared.wire.credentials import Credentials
from shared.wire.endpoint import DEFAULT_ENDPOINT as DEFAULT_ENDPOINT
from shared.wire.endpoint import BusError, NoRouter
from shared.wire.subscription import Subscription
from shared.wire.turn import Turn
from shared.wire.zenoh import ZenohBus

Robot = Annotated[
    str, typer.Option("--robot", envvar="TANDEM_ROBOT", help="First part of every key: which robot this is about.")
]
Connect = Annotated[
    str, typer.Option("--connect", envvar="TANDEM_CONNECT", help="Endpoint of the router of the running stack.")
]
Router = Annotated[
    str, typer.Option("--router", envvar="TANDEM_CONNECT", help="Endpoint that the stack's own router listens on.")
]
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
USAGE = 2
"""Exit status of a command that was given something it cannot take."""


def refuse(text: str, status: int = USAGE) -> NoReturn:
    """Ends the command with one clear line on standard error."""
    typer.echo(f"tandem: {text}", err=True)
    raise typer.Exit(status)


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


def ask(bus: Bus, query: Query, request: dict[str, Any], timeout: float = 3.0, silence: str = "") -> dict[str, Any]:
    """The reply of a running service within a time [s]; its refusal or silence ends the command with one line.

    ``silence`` is what that means; without it, it is found out.
    """
    try:
        return Client(bus).ask(query, request, timeout)
    except NoReply:
        if silence:
            refuse(f"no answer on {query.key} within {timeout:g} s: {silence}", 1)
        there = not bus.living().isdisjoint(speakers(query.server))
        why = f"{query.server} lives, but does not answer" if there else f"{query.server} is not running"
        refuse(f"no answer on {query.key} within {timeout:g} s: {why}. See: tandem status", 1)
    except Refused as problem:
        refuse(f"{query.server} refused: {problem}", 1)


def go_first(turn: Turn) -> None:
    """Refuses if somebody else publishes what this command is about to: its messages would be refused all the time."""
    who = turn.taken()
    if who:
        remedy = TAKE_OVER.get(who, "end it where it runs (Ctrl-C)")
        refuse(f"{who} publishes {turn.topic.key} and was first: nothing of this command is followed. {remedy}", 1)


def unheard(subscription: Subscription) -> str:
    """Why there is no message of a topic: nothing came, or nothing that came could be used; empty if there is one,
    though it may say itself that it is not to be trusted.
    """
    fault = subscription.fault(subscription.now_ns(), math.inf)
    if fault is None or fault.kind is FaultKind.INVALID:
        return ""
    return f"{str(fault).rstrip(chr(46))} See: tandem status"


def table(*columns: str, vertical: Literal["top", "bottom"] = "top", **options: Any) -> Table:
    """An empty table without lines; a column whose name ends with > is set to the right."""
    made = Table(box=None, pad_edge=False, header_style="bold", **options)
    for name in columns:
        justify: Literal["left", "right"] = "right" if name.endswith(">") else "left"
        made.add_column(name.removesuffix(">"), justify=justify, vertical=vertical, overflow="fold")
    return made


def three(option: str, text: str) -> list[float]:
    """One number for all axes, or three; refuses what is neither."""
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        refuse(f"{option} {text!r}: wanted a number or three, separated by commas")
    if len(values) not in (1, 3):
        refuse(f"{option} {text!r}: wanted one number or three, got {len(values)}")
    return values * 3 if len(values) == 1 else values


def stop_event() -> threading.Event:
    """An event that Ctrl-C, SIGTERM and SIGHUP set."""
    event = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda *_: event.set())
    return event
