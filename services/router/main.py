"""The router as a process: opens one Zenoh session in router mode and keeps it until a signal."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path

from shared.loop.config import Misconfigured, OneLineParser, complain
from shared.loop.process import StopRequest
from shared.wire.credentials import Credentials
from shared.wire.endpoint import DEFAULT_ENDPOINT, BusError
from shared.wire.zenoh_sessions import open_router

NAME = "router"


def main(arguments: Sequence[str] | None = None) -> int:
    """Route until SIGTERM or SIGINT.

    Returns:
        Exit status: 0 after a signal, 2 with one line on standard error if it cannot listen.
    """
    stop = StopRequest()
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
    try:
        options = parser.parse_args(arguments)
        robots = options.robot or os.environ.get("TANDEM_ROBOT", "tiago").split(",")
        others = options.link or [other for other in os.environ.get("TANDEM_LINK", "").split(",") if other]
        session = open_router(options.listen, options.config, Credentials.of(options.secure), robots, others)
    except (BusError, Misconfigured) as problem:
        return complain(NAME, problem)
    where = f"as {options.config} says" if options.config else f"on {options.listen}"
    print(f"{NAME}: listening {where}", file=sys.stderr, flush=True)
    try:
        while not stop.requested:
            # With an end: a signal that reaches one of Zenoh's threads does not interrupt this one's wait.
            stop.wake.wait(0.2)
    finally:
        session.close()
    return 0
