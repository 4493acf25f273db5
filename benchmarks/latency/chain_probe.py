"""Source and sink of the chain: ``python -m benchmarks.latency.chain_probe <endpoint> <rate> <seconds>``.

The mock robot with the real gate: its ``sensor/ft`` puts and the arrivals of ``command/ee_twist`` are timed on its bus.
"""

from __future__ import annotations

import sys
import threading
import time

import numpy as np

from benchmarks.latency.pacing import printed
from services.mock.parameters import MockParameters
from services.mock.robot import MockRobot
from shared.clock import SteadyClock, seconds
from shared.loop.runner import Runner
from shared.messages import ControlTarget
from shared.topics import COMMAND_EE_TWIST, CONTROL_TARGET, SENSOR_FT, health_topic
from shared.wire.bus import OnPayload, Work
from shared.wire.client import Client
from shared.wire.zenoh import ZenohBus
from tests.support.wait import eventually

WARM_UP = 1.0
"""Time [s] between the first command that the gate executes and the measurement."""
PATIENCE = 20.0
"""Longest time [s] to wait for the services, and for that command."""
SERVICES = ("wrench", "controller")


class TimedBus(ZenohBus):
    """A bus that notes when samples leave and commands arrive, in ns of the steady clock."""

    def __init__(self, endpoint: str) -> None:
        super().__init__(connect=endpoint)
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


class Probe:
    """The robot, its pose as the target, and the services' counts of overruns."""

    def __init__(self, endpoint: str, rate: float) -> None:
        self.bus = TimedBus(endpoint)
        eventually(lambda: self.bus.living() >= set(SERVICES), PATIENCE, "wrench and controller run")
        self.robot = MockRobot(MockParameters(rate=rate))
        client = Client(self.bus)
        self.health = [client.watch(health_topic(name)) for name in SERVICES]
        self._clock = SteadyClock()
        self.began = time.monotonic()
        self._runner = Runner(self.robot, self.bus, self._clock)
        self._done = threading.Event()
        threading.Thread(target=self._aim, args=(client,), daemon=True).start()

    def _aim(self, client: Client) -> None:
        target = ControlTarget(
            self.robot.motors.position, (0.0, 0.0, 0.0, 1.0), np.full(3, 25.0), np.full(3, 10.0)
        )
        while not self._done.wait(0.2):
            client.publish(CONTROL_TARGET, target)

    def run(self, duration: float) -> None:
        """Be the robot for ``duration`` [s]."""
        end = self._clock.now_ns() + round(duration * 1e9)
        while self._clock.now_ns() < end:
            left = seconds(self._runner.next_deadline() - self._clock.now_ns())
            if left > 0:
                time.sleep(left)
            self._runner.poll()

    def overruns(self) -> dict[str, int]:
        """Overruns since the start of each service."""
        return {
            name: subscription.latest.message.overruns if subscription.latest else -1
            for name, subscription in zip(SERVICES, self.health, strict=True)
        }

    def close(self) -> None:
        """Leave the bus."""
        self._done.set()
        self.bus.close()


def main() -> int:
    """Print the latencies [us] and the overruns in between as JSON; 1 if no command came."""
    endpoint, rate, duration = sys.argv[1], float(sys.argv[2]), float(sys.argv[3])
    probe = Probe(endpoint, rate)
    while probe.robot.side.mode != "ready":
        probe.run(0.01)
        if time.monotonic() - probe.began > PATIENCE:
            print(f"no command was executed within {PATIENCE:g} s", file=sys.stderr)
            return 1
    first_command = time.monotonic() - probe.began
    probe.run(WARM_UP)
    before, begin = probe.overruns(), time.monotonic_ns()
    probe.run(duration)
    end = time.monotonic_ns()
    probe.run(0.6)
    after = probe.overruns()
    probe.close()
    overruns = {name: after[name] - before[name] for name in SERVICES}
    printed(probe.bus.puts, probe.bus.arrivals, begin, end, overruns=overruns, first_command=first_command)
    return 0


if __name__ == "__main__":
    sys.exit(main())
