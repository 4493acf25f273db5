"""Three fifths of the messages are lost, at random, at the default rate."""

import random

from tests.faults.programs.robot import play

LOST = 0.6

if __name__ == "__main__":
    play(lambda key, payload: () if random.random() < LOST else (payload,), rate=100.0)
