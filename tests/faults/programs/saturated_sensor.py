"""The robot declares that an axis of its sensor is at the end of its range."""

from tests.faults.programs.robot import altered, play, sensor_only

if __name__ == "__main__":
    play(sensor_only(lambda payload: (altered(payload, saturated=True, force=[400.0, 0.0, 0.0]),)))
