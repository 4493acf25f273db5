"""The router as a process: opens one Zenoh session in router mode and keeps it until a signal."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from services.router.closed import Closed
from shared.loop.config import Misconfigured, OneLineParser, complain
from shared.loop.healthy import tell
from shared.loop.process import StopRequest
from shared.wire.credentials import Credentials
from shared.wire.endpoint import DEFAULT_ENDPOINT, BusError
from shared.wire.zenoh_sessions import open_router, router_file, router_settings

NAME = "router"
LOOK_EVERY = 0.2
"""Time [s] between two looks at signals and files; with an end, since a signal that reaches one of Zenoh's threads does
not interrupt this one's wait."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Route until SIGTERM or SIGINT.

    Returns:
        Exit status: 0 after a signal, 2 with one line on standard error if it cannot listen.
    """
    stop = StopRequest()
    try:
        options = _options(arguments)
        credentials = None if options.config else Credentials.of(options.secure, participant=NAME)
        robots = options.robot or os.environ.get("TANDEM_ROBOT", "tiago").split(",")
        settings = options.config or router_settings(options.listen, credentials, robots, options.link)
        if options.print_config:
            print(router_file(settings))
            return 0
        # Of routers that are linked one speaks for all.
        closed = Closed(credentials, options.listen, () if options.link else robots, _report) if credentials else None
        session = open_router(settings)
    except (BusError, Misconfigured) as problem:
        return complain(NAME, problem)
    where = f"as {options.config} says" if options.config else f"on {options.listen}"
    _report(f"listening {where}")
    try:
        if closed:
            closed.opened(session)
        while not stop.requested:
            tell("ok")
            stop.wake.wait(LOOK_EVERY)
            if closed and closed.look(session):
                _report(f"its certificate was renewed: listening anew {where}")
                session.close()
                session = open_router(settings)
                closed.opened(session)
    except BusError as problem:
        return complain(NAME, problem)
    finally:
        session.close()
    return 0


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = OneLineParser(prog=f"python -m services.{NAME}")
    parser.add_argument(
        "--listen",
        default=os.environ.get("TANDEM_LISTEN", DEFAULT_ENDPOINT),
        help="endpoint to listen on (default: %(default)s); the other processes need it as --connect",
    )
    parser.add_argument("--config", type=Path, help="Zenoh's own JSON5 configuration, which then decides everything")
    parser.add_argument(
        "--secure",
        default=os.environ.get("TANDEM_SECURE", ""),
        metavar="FOLDER",
        help="certificates of the router, made by `tandem keys`: nobody does anything but what a certificate allows",
    )
    parser.add_argument(
        "--robot",
        action="append",
        help="robots that it serves with --secure; may be given several times (default: tiago)",
    )
    parser.add_argument(
        "--link",
        action="append",
        metavar="ENDPOINT",
        help="router of another machine, whose participants this one's hear; may be given several times, and is given "
        "to one of the two (default: TANDEM_LINK, separated by commas)",
    )
    parser.add_argument(
        "--print-config",
        action="store_true",
        help="write what these options mean as a configuration of Zenoh's own router, `zenohd -c FILE`, and end",
    )
    options = parser.parse_args(arguments)
    if options.print_config and options.config:
        raise Misconfigured("--print-config and --config: that file is one of Zenoh's already; choose one of them")
    options.link = options.link or [other for other in os.environ.get("TANDEM_LINK", "").split(",") if other]
    return options


def _report(line: str) -> None:
    print(f"{NAME}: {line}", file=sys.stderr, flush=True)
