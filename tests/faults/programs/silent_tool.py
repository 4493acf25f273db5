"""The tool's pose stops; the sensor goes on."""

from shared.topics import STATE_EE
from tests.faults.programs.robot import play

if __name__ == "__main__":
    play(lambda key, payload: () if key == STATE_EE.key else (payload,))
