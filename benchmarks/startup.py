"""Time from the robot's start to the first command that it may execute; all other processes already run.

``python -m benchmarks.startup [--quick]``. Half a second of it is the services' own waiting for healthy inputs.
"""

from __future__ import annotations

import argparse

from benchmarks.latency.segments import started
from benchmarks.table import Row, at_most, show

COMMAND = "python -m benchmarks.startup"
LIMIT = 1.5
"""Time [s] aimed at."""


def rows(quick: bool) -> list[Row]:
    """The longest of several starts."""
    times = sorted(started() for _ in range(2 if quick else 10))
    note = f"longest of {len(times)}, median {times[len(times) // 2]:.2f} s"
    return [at_most("robot there to first safe command", times[-1], LIMIT, "s", COMMAND, note)]


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(prog=COMMAND, description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer starts: a look, not a measurement")
    show(rows(parser.parse_args().quick))


if __name__ == "__main__":
    main()
