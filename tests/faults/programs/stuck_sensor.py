"""One axis of the sensor repeats a value for ever; the others live."""

import msgpack

from tests.faults.programs.robot import altered, play, sensor_only


def stuck(payload: bytes) -> tuple[bytes, ...]:
    force = msgpack.unpackb(payload)["force"]
    return (altered(payload, force=[force[0], 1.25, force[2]]),)


if __name__ == "__main__":
    play(sensor_only(stuck))
