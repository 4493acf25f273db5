"""A fifth of the messages is lost, at random, at the default rate."""

import random

from tests.faults.programs.robot import play

LOST = 0.2

if __name__ == "__main__":
    play(lambda key, payload: () if random.random() < LOST else (payload,), rate=100.0)
