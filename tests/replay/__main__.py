"""Makes recordings and expectations, and compares revisions: ``python -m tests.replay COMMAND``."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from tests.replay import cases, compare, expectations
from tests.replay.player import play
from tests.replay.recordings import INPUTS


def main() -> int:
    """Run one command; returns the exit status."""
    parser = argparse.ArgumentParser(prog="python -m tests.replay", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("record", help="make recordings and expectations anew, from the simulation")
    commands.add_parser("expect", help="make the expectations anew from the stored recordings")
    digest = commands.add_parser("digest", help="print a checksum of all answers for each case and key")
    digest.add_argument("--inputs", type=Path, default=INPUTS, help="folder of the recordings and cases")
    against = commands.add_parser("compare", help="compare with another revision, to the last bit")
    against.add_argument("revision", metavar="REV", help="of git, such as HEAD")
    given = parser.parse_args()
    if given.command == "compare":
        return compare.compare(given.revision)
    if given.command == "digest":
        for line in compare.lines(given.inputs):
            print(line, flush=True)
        return 0
    if given.command == "record":
        # Only here: it needs the simulation, which a replay does without.
        from tests.replay.record import record

        record(INPUTS)
    for case in cases.cases():
        path = expectations.path_of(case)
        expectations.save(path, play(case))
        print(f"{path.name}: {path.stat().st_size} bytes")
    return 0


if __name__ == "__main__":
    sys.exit(main())
