"""Makes the golden recordings, and compares revisions: ``python -m tests.replay COMMAND``."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from tests.replay import compare
from tests.replay.record import RECORDINGS, expect, record


def main() -> int:
    """Run one command; returns the exit status."""
    parser = argparse.ArgumentParser(prog="python -m tests.replay", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("record", help="make the recordings anew, from the simulation")
    commands.add_parser("expect", help="take the present answers for right: what was heard of the robot stays")
    digest = commands.add_parser("digest", help="print a checksum of all answers for each recording, service and key")
    digest.add_argument("--recordings", type=Path, default=RECORDINGS, help="folder of the recordings")
    against = commands.add_parser("compare", help="compare with another revision, to the last bit")
    against.add_argument("revision", metavar="REV", help="of git, such as HEAD")
    given = parser.parse_args()
    match given.command:
        case "compare":
            return compare.compare(given.revision)
        case "digest":
            for line in compare.lines(given.recordings):
                print(line, flush=True)
        case "record":
            record()
        case "expect":
            expect()
    return 0


if __name__ == "__main__":
    sys.exit(main())
