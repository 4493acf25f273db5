"""A script that holds a pose, has a bag pull at the tool, and reads force and height: beside `tandem up`.

`python -m examples.hold_push_read [ENDPOINT]` takes 15 s; `tandem tare`, `hold`, `load` and `topic echo` do the same.
"""

import sys
import time
from contextlib import closing

import numpy as np

from shared.messages import ControlTarget
from shared.parameters import Refused
from shared.spatial import GRAVITY, quaternion_from_rpy
from shared.topics import CONTROL_TARGET, SIM_COMMAND, STATE_EE, WRENCH_EXTERNAL, WRENCH_TARE
from shared.wire.bus import NoReply
from shared.wire.client import Client
from shared.wire.endpoint import DEFAULT_ENDPOINT, BusError
from shared.wire.zenoh import ZenohBus

TARGET = ControlTarget(
    np.array((0.5, -0.3, 1.0)), quaternion_from_rpy(0.0, 0.0, 0.0), np.full(3, 25.0), np.full(3, 10.0)
)
"""Pose of the tool [m], and what it may be pushed with, axis by axis [N, Nm]."""


def main(endpoint: str = DEFAULT_ENDPOINT) -> None:
    """Tare, then hold while nothing, a bag of 10 N and again nothing hangs from the tool."""
    with closing(ZenohBus("tiago", endpoint)) as bus:
        client = Client(bus, name="example")
        wrench, tool = client.watch(WRENCH_EXTERNAL), client.watch(STATE_EE)
        client.ask(WRENCH_TARE, {"duration": 1.0}, timeout=4.0)
        for weight in (0.0, 10.0, 0.0):  # [N]
            client.ask(SIM_COMMAND, {"command": "load", "mass": weight / GRAVITY})
            for _ in range(50):
                client.publish(CONTROL_TARGET, TARGET)  # after a second of silence somebody else may say what to hold
                time.sleep(0.1)
            if wrench.latest and tool.latest:
                force, height = wrench.latest.message.force[2], tool.latest.message.position[2]
                print(f"{weight:4.1f} N hang from it: force z {force:+6.2f} N, tool at {height:.3f} m", flush=True)


if __name__ == "__main__":
    try:
        main(*sys.argv[1:2])
    except (BusError, NoReply, Refused) as problem:
        sys.exit(str(problem))
