"""The force-torque samples stop; everything else of the robot goes on."""

from tests.faults.programs.robot import play, sensor_only

if __name__ == "__main__":
    play(sensor_only(lambda payload: ()))
