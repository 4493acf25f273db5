"""Source and sink: ``python -m benchmarks.latency.chain_probe <robot> <endpoint> <rate> <seconds> <links> [<keys>]``.

The mock robot with the real gate: its ``sensor/ft`` puts and the arrivals of ``command/ee_twist`` are timed on its bus.
"""

from __future__ import annotations

import sys
import threading
import time

import numpy as np

from benchmarks.latency.pacing import WARM_UP, printed
from services.mock.parameters import MockParameters
from services.mock.robot import MockRobot
from shared.messages import ControlTarget
from shared.processes import LINKED
from shared.topics import COMMAND_EE_TWIST, CONTROL_TARGET, ROBOT, SENSOR_FT, health_topic
from shared.wire.bus import OnPayload, Work
from shared.wire.client import Client
from shared.wire.credentials import Credentials
from shared.wire.links import links_of
from shared.wire.zenoh import ZenohBus
from tests.support.spoilt_bus import live
from tests.support.wait import eventually

PATIENCE = 20.0
"""Longest time [s] to wait for the services, and for the first command."""
SERVICES = ("wrench", "controller")


class TimedBus(ZenohBus):
    """A bus that notes when samples leave and commands arrive, in ns of the steady clock."""

    def __init__(self, robot: str, endpoint: str, links: str, credentials: Credentials | None) -> None:
        direct = links_of(ROBOT, LINKED, links, robot, endpoint)
        super().__init__(robot, endpoint, links=direct, credentials=credentials)
        self.link()
        self.puts: list[int] = []
        self.arrivals: list[int] = []

    def publish(self, key: str, payload: bytes) -> None:
        """As the bus does; notes the instant before the put of a sample."""
        if key == SENSOR_FT.key:
            self.puts.append(time.monotonic_ns())
        super().publish(key, payload)

    def subscribe(self, key: str, on_payload: OnPayload, work: Work | None = None) -> None:
        """As the bus does; notes the instant of a command's arrival."""
        if key != COMMAND_EE_TWIST.key:
            super().subscribe(key, on_payload, work)
            return

        def timed(payload: bytes) -> None:
            self.arrivals.append(time.monotonic_ns())
            on_payload(payload)

        super().subscribe(key, timed, work)


def main() -> None:
    """Print the latencies [us] and the overruns in between as JSON."""
    rate, duration = float(sys.argv[3]), float(sys.argv[4])
    # On a closed network nobody may aim but who has a certificate for it, and the robot has not.
    keys = {name: Credentials.of(f"{sys.argv[6]}/{name}") if sys.argv[6:] else None for name in ("mock", "operator")}
    name, endpoint, links, ended = sys.argv[1], sys.argv[2], sys.argv[5], threading.Event()
    bus = TimedBus(name, endpoint, links, keys["mock"])
    outside = ZenohBus(name, endpoint, credentials=keys["operator"]) if keys["operator"] else bus
    eventually(lambda: bus.living() >= set(SERVICES), PATIENCE, "wrench and controller run")
    client, robot = Client(outside), MockRobot(MockParameters(rate=rate))
    health = {name: client.watch(health_topic(name)) for name in SERVICES}
    target = ControlTarget(robot.motors.position, (0.0, 0.0, 0.0, 1.0), np.full(3, 25.0), np.full(3, 10.0))

    def aim() -> None:
        while not ended.wait(0.2):
            client.publish(CONTROL_TARGET, target)

    def overruns() -> dict[str, int]:
        return {
            name: subscription.latest.message.overruns if subscription.latest else -1
            for name, subscription in health.items()
        }

    threads = [threading.Thread(target=aim), threading.Thread(target=live, args=(robot, bus, ended.is_set))]
    began = time.monotonic()
    for thread in threads:
        thread.start()
    try:
        eventually(lambda: robot.side.mode == "ready", PATIENCE, "a command is executed")
        first_command = time.monotonic() - began
        time.sleep(WARM_UP)
        before, begin = overruns(), time.monotonic_ns()
        time.sleep(duration)
        end = time.monotonic_ns()
        # The services' health comes twice a second.
        time.sleep(0.6)
        late = {name: count - before[name] for name, count in overruns().items()}
    finally:
        ended.set()
        for thread in threads:
            thread.join()
        bus.close()
        if outside is not bus:
            outside.close()
    printed(bus.puts, bus.arrivals, begin, end, overruns=late, first_command=first_command)


if __name__ == "__main__":
    main()
