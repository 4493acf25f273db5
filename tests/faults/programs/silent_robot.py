"""Everything that the robot publishes stops."""

from tests.faults.programs.robot import play

if __name__ == "__main__":
    play(lambda key, payload: ())
