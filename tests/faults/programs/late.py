"""Every message comes a third of a second after it was made: a slow network, unnoticed but for the stamps."""

from collections import defaultdict, deque

from tests.faults.programs.robot import play

LATE_BY = 10
waiting: defaultdict[str, deque[bytes]] = defaultdict(deque)


def spoil(key: str, payload: bytes) -> tuple[bytes, ...]:
    queue = waiting[key]
    queue.append(payload)
    return (queue.popleft(),) if len(queue) > LATE_BY else ()


if __name__ == "__main__":
    play(spoil)
