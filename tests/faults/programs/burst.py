"""Nothing for half a second, then everything that was held back at once, and so on."""

from collections import defaultdict

from tests.faults.programs.robot import play

HELD_BACK = 15
held: defaultdict[str, list[bytes]] = defaultdict(list)


def spoil(key: str, payload: bytes) -> tuple[bytes, ...]:
    held[key].append(payload)
    if len(held[key]) < HELD_BACK:
        return ()
    sent = tuple(held[key])
    held[key].clear()
    return sent


if __name__ == "__main__":
    play(spoil)
