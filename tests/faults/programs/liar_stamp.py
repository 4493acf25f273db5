"""Stamps that jump an hour ahead now and then, under the true session."""

import itertools

import msgpack

from tests.faults.programs.robot import altered, play

HOUR_NS = 3_600 * 10**9
turn = itertools.count()


def spoil(_key: str, payload: bytes) -> tuple[bytes, ...]:
    if next(turn) % 21:
        return (payload,)
    return (altered(payload, stamp=msgpack.unpackb(payload)["stamp"] + HOUR_NS),)


if __name__ == "__main__":
    play(spoil)
