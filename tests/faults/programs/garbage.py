"""Random bytes under every key of the robot."""

import random

from tests.faults.programs.robot import play

if __name__ == "__main__":
    play(lambda key, payload: (random.randbytes(random.randrange(200)),))
