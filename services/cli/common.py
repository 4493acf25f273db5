"""Options that every command shares, and opening the bus with them."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Annotated

import typer

from services.cli.refusal import refuse
from services.cli.stack.plan import DEFAULT_ENDPOINT
from shared.wire.zenoh import BusError, ZenohBus

Robot = Annotated[
    str,
    typer.Option(
        "--robot", envvar="TANDEM_ROBOT", help="First part of every key: which robot this is about."
    ),
]
Connect = Annotated[
    str,
    typer.Option("--connect", envvar="TANDEM_CONNECT", help="Endpoint of the router of the running stack."),
]
DEFAULT_ROBOT = "tiago"
CONNECT_WITHIN = 2.0  # [s]

__all__ = ["DEFAULT_ENDPOINT", "DEFAULT_ROBOT", "Connect", "Robot", "open_bus"]


@contextmanager
def open_bus(
    robot: str, connect: str, within: float = CONNECT_WITHIN, give_up: Callable[[], bool] = lambda: False
) -> Iterator[ZenohBus]:
    """The bus of a running stack; refuses with one line when no router answers `within` [s] or until `give_up`."""
    if not robot or any(letter in robot for letter in "/*$#?"):
        refuse(f"--robot {robot!r}: wanted one chunk of a key, without / * $ # ?")
    deadline = time.monotonic() + within
    try:
        bus = ZenohBus(robot, connect, give_up=lambda: give_up() or time.monotonic() > deadline)
    except BusError as problem:
        if give_up() or time.monotonic() > deadline:
            refuse(
                f"no router at {connect}. Start a stack with: tandem up, or choose another with --connect", 1
            )
        refuse(str(problem))
    try:
        yield bus
    finally:
        bus.close()
