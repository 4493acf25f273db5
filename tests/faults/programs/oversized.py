"""A megabyte in place of every message."""

from tests.faults.programs.robot import altered, play

if __name__ == "__main__":
    play(lambda key, payload: (altered(payload, padding=bytes(1_000_000)),))
