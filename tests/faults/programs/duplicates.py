"""Every message comes three times, and the last ten before it once more, in reverse."""

from collections import defaultdict, deque

from tests.faults.programs.robot import play

past: defaultdict[str, deque[bytes]] = defaultdict(lambda: deque(maxlen=10))


def spoil(key: str, payload: bytes) -> tuple[bytes, ...]:
    again = tuple(reversed(past[key]))
    past[key].append(payload)
    return (payload, payload, *again, payload)


if __name__ == "__main__":
    play(spoil)
