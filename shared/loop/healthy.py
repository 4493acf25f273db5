"""Whether a service works, by its own word over the bus: `python -m shared.loop.healthy NAME`, for health checks.

The exit status is 0 if it does; else 1, and one line says why. Robot and router are those of the environment, as for
the service itself. It imports little: several containers ask every few seconds on the cores that control.
"""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Sequence

from shared.clock import SteadyClock
from shared.loop.entry import end
from shared.processes import ROUTER
from shared.topics import HEALTH_RATE, health_topic
from shared.wire.credentials import Credentials
from shared.wire.endpoint import DEFAULT_ENDPOINT, BusError
from shared.wire.subscription import Subscription
from shared.wire.zenoh import ZenohBus

CONNECT_WITHIN = 1.5  # [s]
HEARD_WITHIN = 3.0 / HEALTH_RATE  # [s]


def main(arguments: Sequence[str] | None = None) -> int:
    """Asks one service, or the router."""
    (name,) = sys.argv[1:] if arguments is None else arguments
    robot = os.environ.get("TANDEM_ROBOT", "tiago")
    deadline = time.monotonic() + CONNECT_WITHIN
    try:
        connect, credentials = os.environ.get("TANDEM_CONNECT", DEFAULT_ENDPOINT), Credentials.given()
        bus = ZenohBus(robot, connect, lambda: time.monotonic() > deadline, credentials=credentials)
    except BusError as problem:
        print(problem)
        return 1
    # Whoever has let us in routes.
    wrong = "" if name == ROUTER.name else trouble(bus, name)
    if wrong:
        print(f"{name}: {wrong}")
    return 1 if wrong else 0


def trouble(bus: ZenohBus, name: str) -> str:
    """Why a service does not work, in its own words; empty if it does."""
    heard = threading.Event()
    health = Subscription(health_topic(name), SteadyClock(), lambda _: heard.set())
    bus.subscribe(health.topic.key, health.offer)
    if not heard.wait(HEARD_WITHIN) or health.latest is None:
        return f"nothing was heard of its health within {HEARD_WITHIN:g} s"
    said = health.latest.message
    return "" if said.state == "ok" else f"{said.state}: {said.detail}"


if __name__ == "__main__":
    end(main())
