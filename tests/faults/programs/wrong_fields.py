"""Each field in turn missing, of a wrong type, of a wrong shape or nested a thousand lists deep."""

import itertools

import msgpack

from tests.faults.programs.robot import altered, play

DEEP = b"\x91" * 1020 + b"\xc0"
WRONG = itertools.cycle((None, True, "text", b"bytes", [], [1.0], [[0.0] * 3] * 3, {"x": 1.0}, 2**64 - 1, -1))
turn = itertools.count()


def spoil(_key: str, payload: bytes) -> tuple[bytes, ...]:
    fields = msgpack.unpackb(payload)
    name = sorted(fields)[next(turn) % len(fields)]
    wrong = altered(payload, **{name: next(WRONG)})
    del fields[name]
    missing = msgpack.packb(fields)
    nested = bytes([0x80 + len(fields) + 1]) + missing[1:] + msgpack.packb(name) + DEEP
    return (missing, nested, wrong)


if __name__ == "__main__":
    play(spoil)
