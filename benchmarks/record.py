"""What the recorder costs the chain, and what it hears of it: ``python -m benchmarks.record [--quick]``.

The chain over direct links, in turns with the same while `services.recorder` writes all that is said to the disk; then
each recording is replayed, and its answers are held against those that were given live.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.latency import segments
from benchmarks.latency.segments import Segment
from benchmarks.table import Row, at_most, show, shown
from services.experiment.replay.equality import equality
from services.experiment.replay.replay import complete, replay
from shared.wire.log import recordings

COMMAND = "python -m benchmarks.record"
RATE = 100.0  # [Hz]
LIMIT = 1.05
"""Largest ratio of the chain's latencies with the recorder to those without."""


def rows(quick: bool) -> list[Row]:
    """Latency with and without the recorder, and how much of what was recorded is answered alike."""
    rounds, seconds = (2, 3.0) if quick else (8, 10.0)
    without, beside = Segment(), Segment()
    outputs = {"wrench": (0, 0, 0), "controller": (0, 0, 0)}
    for turn in range(rounds):
        with TemporaryDirectory() as name:
            # Who goes first takes turns, too.
            for recorded in (turn % 2 == 0, turn % 2 == 1):
                if recorded:
                    beside.add(segments.recorded(RATE, seconds, Path(name)))
                else:
                    without.add(segments.linked(RATE, seconds))
            for service, before in outputs.items():
                found = _replayed(Path(name), service)
                outputs[service] = (before[0] + found[0], before[1] + found[1], before[2] + found[2])
    title = f"chain at {RATE:.0f} Hz with the recorder to that without"
    table = []
    for name, share in (("p50", 0.5), ("p99", 0.99)):
        one, other = beside.quantile(share), without.quantile(share)
        table.append(at_most(f"{title}, {name}", one / other, LIMIT, "", COMMAND, f"{one:.0f} us, {other:.0f} us"))
    for service, (equal, compared, missing) in outputs.items():
        note = f"{equal:,} of {compared:,}; {missing:,} messages that it took were not heard"
        claim = f"live outputs of {service} that a replay gives to the last bit"
        table.append(shown(claim, 100.0 * equal / compared, "%", COMMAND, note))
    return table


def _replayed(folder: Path, service: str) -> tuple[int, int, int]:
    """Outputs that are equal, that are compared, and messages that were not heard."""
    (paths,) = recordings(folder)
    read, _ = complete(paths, service)
    found = [equality(life, replay(read, life, {})) for life in read.lives]
    return sum(one.equal for one in found), sum(one.compared for one in found), sum(one.missing for one in found)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(prog=COMMAND, description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer samples: a look, not a measurement")
    show(rows(parser.parse_args().quick))


if __name__ == "__main__":
    main()
