"""One message of a sequence number far ahead, then the true ones go on: everything after it looks old."""

from tests.faults.programs.robot import altered, play

jumped: set[str] = set()


def spoil(key: str, payload: bytes) -> tuple[bytes, ...]:
    if key in jumped:
        return (payload,)
    jumped.add(key)
    return (altered(payload, seq=2**62),)


if __name__ == "__main__":
    play(spoil)
