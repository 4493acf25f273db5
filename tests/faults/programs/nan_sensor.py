"""A component of the measured force is not a number."""

import math

from tests.faults.programs.robot import altered, play, sensor_only

if __name__ == "__main__":
    play(sensor_only(lambda payload: (altered(payload, force=[0.0, math.nan, 0.0]),)))
