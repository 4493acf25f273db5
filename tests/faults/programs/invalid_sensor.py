"""The robot itself says that its samples are not to be trusted."""

from tests.faults.programs.robot import altered, play, sensor_only

if __name__ == "__main__":
    play(sensor_only(lambda payload: (altered(payload, valid=False),)))
