"""Whether the stack in containers keeps its rate: ``python -m benchmarks.containers [--quick]``, without the camera.

Robot, wrench, controller and base hold a pose at 100 Hz for a minute; late steps are those that the services count
themselves. It needs Docker. How long it takes from `up` to a robot that may move is measured on the way.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from concurrent.futures import ThreadPoolExecutor

from benchmarks.table import Row, at_most, show
from tests.support.compose import Compose, unusable

COMMAND = "python -m benchmarks.containers"
MEASURED = ("sim", "wrench", "controller", "base")
HEALTH_RATE = 2  # [Hz]
LATE_LIMIT, MOVING_LIMIT = 0.1, 15.0  # [%] and [s] aimed at


def rows(quick: bool) -> list[Row]:
    """Share of late steps of each service, and the time to a robot that may move."""
    if why := unusable():
        raise SystemExit(f"{COMMAND}: {why}")
    with Compose("tandem-benchmark") as stack:
        began = time.monotonic()
        stack.do("up", "-d", "router", *MEASURED)
        while stack.tandem("tare").returncode:
            pass
        tared = time.monotonic() - began
        stack.do("run", "-d", "--rm", "tandem", "hold", "0.45", "-0.39", "0.8", "-1.57", "0", "0")
        stack.healthy(*MEASURED)
        count = HEALTH_RATE * (10 if quick else 60) + 1
        load = os.getloadavg()[0]
        with ThreadPoolExecutor() as pool:
            late = dict(zip(MEASURED, pool.map(lambda name: _late(stack, name, count), MEASURED), strict=True))
    note = f"load average {load:.1f} before"
    return [
        at_most("containers: `up` to a tared robot", tared, MOVING_LIMIT, "s", COMMAND, note),
        *(at_most(f"containers: late steps of {name}", late[name], LATE_LIMIT, "%", COMMAND, note) for name in late),
    ]


def _late(stack: Compose, name: str, count: int) -> float:
    """Share [%] of a service's steps that were late during so many messages of its health."""
    done = stack.run(
        "run", "--rm", "-T", "tandem", "topic", "echo", f"health/{name}", "--count", str(count), timeout=180.0
    )
    heard = [json.loads(line) for line in done.stdout.splitlines()]
    steps = sum(message["loop_hz"] for message in heard[1:]) / HEALTH_RATE
    return 100.0 * (heard[-1]["overruns"] - heard[0]["overruns"]) / steps


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(prog=COMMAND, description=__doc__)
    parser.add_argument("--quick", action="store_true", help="ten seconds: a look, not a measurement")
    show(rows(parser.parse_args().quick))


if __name__ == "__main__":
    main()
