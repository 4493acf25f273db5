"""Three hundred messages in place of one: 9 kHz on every topic of the robot, each of them new."""

import itertools

import msgpack

from tests.faults.programs.robot import altered, play

count = itertools.count()


def spoil(_key: str, payload: bytes) -> tuple[bytes, ...]:
    stamp = msgpack.unpackb(payload)["stamp"]
    return tuple(
        altered(payload, seq=10**9 + next(count), stamp=stamp + step * 100_000) for step in range(300)
    )


if __name__ == "__main__":
    play(spoil)
