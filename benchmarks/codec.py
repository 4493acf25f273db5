"""What a message costs: ``python -m benchmarks.codec [--against REV]``, in microseconds for each control message.

Decoding includes every check, encoding the building of the message with its header.
"""

from __future__ import annotations

import argparse
import json
import timeit
from pathlib import Path

import numpy as np

from shared import messages as m
from shared.messages import Header
from shared.schema.records import Record
from shared.wire.codec import decode, encode

_ROUNDS, _CALLS = 40, 200
_THREE, _SIX, _TURN = np.array((1.1, -2.2, 3.3)), np.linspace(0.1, 0.6, 6), np.array((0.0, 0.0, 0.6, 0.8))
MESSAGES = {
    m.FtSample: (_THREE, _THREE, _TURN, _THREE, False),
    m.EndEffector: (_THREE, _TURN, _THREE, _THREE),
    m.ExternalWrench: (_THREE, _THREE, _SIX, "payload", ""),
    m.ControlTarget: (_THREE, _TURN, _SIX[:3], _SIX[3:], _THREE, _THREE),
    m.TwistCommand: (_THREE, _THREE, 0.05),
    m.ControlStatus: ("tracking", "", "certified", _SIX, _SIX, _SIX, 0.0, 0.0, 50.0),
    m.BaseTwistCommand: (_THREE, 0.1),
    m.BaseStatus: ("following", _THREE, _THREE),
}
"""Every message of the chains from the wrist to tool and base, with typical fields."""


def cost() -> dict[str, float]:
    """Shortest time [us] of building and encoding, and of decoding and checking, for each message."""
    # As the publisher makes it; versions before records of msgspec have one way only.
    header = getattr(Header, "trusted", Header)
    found = {}
    for message, fields in MESSAGES.items():

        def built(message: type[Record] = message, fields: tuple = fields) -> bytes:
            return encode(message(*fields), header(7, 2**61, 2**45, True))

        payload = built()

        def decoded(message: type[Record] = message, payload: bytes = payload) -> object:
            return decode(message, payload)

        for what, work in (("encode", built), ("decode", decoded)):
            shortest = min(timeit.repeat(work, number=_CALLS, repeat=_ROUNDS)) / _CALLS
            found[f"{message.__name__} {what}"] = shortest * 1e6
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="python -m benchmarks.codec", description=__doc__)
    parser.add_argument("--against", metavar="REV", help="in turns with another revision, from a1bef68 on")
    if revision := parser.parse_args().against:
        from benchmarks import against  # not above: older revisions run this file too, and have none

        against.show(against.compare(revision, Path(__file__).read_text(encoding="utf-8")))
    else:
        print(json.dumps(cost(), indent=2))
