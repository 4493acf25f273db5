"""Every sound message comes with a broken one, a megabyte and an empty one around it."""

from tests.faults.programs.robot import play

if __name__ == "__main__":
    play(lambda key, payload: (b"", payload[:-2], payload, bytes(100_000), b"\xc1"))
