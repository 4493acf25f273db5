"""Faults injected from outside the processes: how soon the robot's gate brakes, and how soon all is well again.

``python -m benchmarks.faults [--quick]`` prints the table of docs/faults.md.
"""

from __future__ import annotations

import argparse
import math
import signal
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import msgpack

from benchmarks.fault_robot import FaultRobot
from benchmarks.table import Row, at_most
from shared.messages import Stop
from shared.topics import CONTROL_TARGET, ROBOT, SENSOR_FT, STOP
from shared.wire.client import Client
from shared.wire.links import NONE
from tests.faults.programs import (
    AHEAD,
    altered,
    garbage,
    nan_sensor,
    only,
    oversized,
    silent_sensor,
    stuck_sensor,
    tared,
)
from tests.support.ports import free_endpoint
from tests.support.processes import Process, Processes
from tests.support.relay import Crossings
from tests.support.spoilt_bus import Spoil

COMMAND = "python -m benchmarks.faults"
LONGEST_WAIT = 120.0
LATEST_GATE = 0.01
"""Longest time [s] between two looks of the robot's gate with which an injection still counts: five of its periods."""
STANDS = 0.3
"""Time [s] for which the robot has to stand to have braked."""
CHAIN = (ROBOT, "wrench", "controller")


class Stack:
    """Router, wrench and controller as processes, and a robot in this one.

    Attributes:
        crossings: where their links can be cut, if they can.
    """

    def __init__(self, processes: Processes, state: str, crossings: Crossings | None = None) -> None:
        self._processes, self._state, self.crossings = processes, state, crossings
        self.endpoint = free_endpoint()
        self.router = self.start("router")
        self.wrench, self.controller = self.start("wrench"), self.start("controller")
        self.robot = FaultRobot(self.endpoint, crossings.patterns[ROBOT] if crossings else NONE)
        processes.callback(self.robot.close)
        self.client = Client(self.robot.bus)
        wait(lambda: tared(self.client))

    def start(self, name: str) -> Process:
        """A process with its defaults, in the place of one that is no more."""
        if name == "router":
            return self._processes.router(self.endpoint)
        links = ("--links", self.crossings.patterns[name]) if self.crossings else ()
        environment = {"XDG_STATE_HOME": self._state}
        return self._processes.start(f"services.{name}", "--connect", self.endpoint, *links, environment=environment)

    def work(self) -> None:
        """Wait for steady motion."""

        def moves() -> bool:
            self.client.publish(CONTROL_TARGET, AHEAD)
            self.client.publish(STOP, Stop(False, "benchmark"))
            return self.robot.moves_for(0.3)

        wait(moves, 0.05)


def wait(condition: Callable[[], bool], interval: float = 0.001) -> None:
    """Until a condition holds.

    Raises:
        TimeoutError: if it did not for two minutes, as on a machine too busy for 100 Hz.
    """
    deadline = time.monotonic() + LONGEST_WAIT
    while not condition():
        if time.monotonic() > deadline:
            raise TimeoutError(f"{getattr(condition, '__qualname__', condition)} did not come true")
        time.sleep(interval)


@dataclass
class Fault:
    """One fault.

    Attributes:
        name: as docs/faults.md calls it.
        promise: time [s] within which the gate has to brake.
        inject: does it; returns its onset [ns].
        mend: undoes it.
        braked: measured times [s] from the onset until the gate braked.
        back: measured times [s] from the mending, the start of a process included, until the robot moved again.
        discarded: injections that say nothing, since the measuring robot itself was not run in time.
    """

    name: str
    promise: float
    inject: Callable[[Stack], int]
    mend: Callable[[Stack], object]
    braked: list[float] = field(default_factory=list)
    back: list[float] = field(default_factory=list)
    discarded: int = 0

    def measure(self, stack: Stack) -> None:
        """Inject it once into working processes."""
        stack.work()
        robot = stack.robot
        robot.longest_gap = 0.0
        onset = self.inject(stack)
        # Not the first stop but the last: whoever moves on after all has not braked.
        wait(lambda: robot.stopped_ns > onset and robot.stands_for(STANDS))
        if robot.longest_gap > LATEST_GATE:
            self.discarded += 1
        else:
            self.braked.append((robot.stopped_ns - onset) * 1e-9)
        mended = time.monotonic_ns()
        self.mend(stack)
        stack.work()
        self.back.append((robot.moving_ns - mended) * 1e-9)


def _spoil(spoil: Spoil) -> Callable[[Stack], int]:
    def inject(stack: Stack) -> int:
        stack.robot.bus.spoil = only(SENSOR_FT, spoil)
        time.sleep(0.012)
        return stack.robot.bus.last_sent_ns[SENSOR_FT.key]

    return inject


def _late(_key: str, payload: bytes) -> tuple[bytes, ...]:
    return (altered(payload, stamp=msgpack.unpackb(payload)["stamp"] - 50_000_000),)


def _sound(stack: Stack) -> None:
    stack.robot.bus.spoil = None


def _signal(name: str, number: signal.Signals) -> Callable[[Stack], int]:
    def inject(stack: Stack) -> int:
        onset = time.monotonic_ns()
        process: Process = getattr(stack, name)
        process.signal(number)
        return onset

    return inject


def _restart(name: str) -> Callable[[Stack], None]:
    def mend(stack: Stack) -> None:
        getattr(stack, name).wait()
        setattr(stack, name, stack.start(name))

    return mend


def _wake(name: str) -> Callable[[Stack], None]:
    return lambda stack: getattr(stack, name).signal(signal.SIGCONT)


def _stop(stack: Stack) -> int:
    onset = time.monotonic_ns()
    stack.client.publish(STOP, Stop(True, "benchmark"))
    return onset


def _faults() -> list[Fault]:
    return [
        Fault("force-torque samples stop", 0.05, _spoil(silent_sensor), _sound),
        Fault("a force is not a number", 0.05, _spoil(nan_sensor), _sound),
        Fault("garbage in place of samples", 0.05, _spoil(garbage), _sound),
        Fault("a megabyte in place of each sample", 0.05, _spoil(oversized), _sound),
        Fault("one axis of the sensor stuck", 0.12, _spoil(stuck_sensor), _sound),
        Fault("samples come 50 ms late, declared are 20", 0.06, _spoil(_late), _sound),
        Fault("stop engaged", 0.02, _stop, lambda stack: None),
        Fault("controller killed", 0.06, _signal("controller", signal.SIGKILL), _restart("controller")),
        Fault("controller hung", 0.06, _signal("controller", signal.SIGSTOP), _wake("controller")),
        Fault("wrench killed", 0.06, _signal("wrench", signal.SIGKILL), _restart("wrench")),
        Fault("wrench hung", 0.06, _signal("wrench", signal.SIGSTOP), _wake("wrench")),
        Fault("router killed", 0.06, _signal("router", signal.SIGKILL), _restart("router")),
        Fault("router hung", 0.06, _signal("router", signal.SIGSTOP), _wake("router")),
    ]


def _cut(source: str, sink: str, passes: bool) -> Callable[[Stack], int]:
    def cut(stack: Stack) -> int:
        onset = time.monotonic_ns()
        assert stack.crossings is not None
        stack.crossings.cut(source, sink, passes)
        return onset

    return cut


def _linked() -> list[Fault]:
    """What happens to processes with direct links."""
    neighbours = ((ROBOT, "wrench"), ("wrench", "controller"), ("controller", ROBOT))
    return [
        *(
            Fault(f"link from {source} to {sink} cut", 0.06, _cut(source, sink, False), _cut(source, sink, True))
            for source, sink in neighbours
        ),
        Fault("linked, controller killed", 0.06, _signal("controller", signal.SIGKILL), _restart("controller")),
        Fault("linked, controller hung", 0.06, _signal("controller", signal.SIGSTOP), _wake("controller")),
        Fault("linked, wrench hung", 0.06, _signal("wrench", signal.SIGSTOP), _wake("wrench")),
        Fault("linked, router killed", 0.06, _signal("router", signal.SIGKILL), _restart("router")),
        Fault("linked, router hung", 0.3, _signal("router", signal.SIGSTOP), _wake("router")),
    ]


def measured(repeats: int) -> Iterator[Fault]:
    """Every fault, injected so many times; each as soon as it is measured."""
    for faults, crossings in ((_faults(), None), (_linked(), Crossings(CHAIN))):
        with tempfile.TemporaryDirectory() as folder, Processes(Path(folder)) as processes:
            stack = Stack(processes, folder, crossings)
            for fault in faults:
                while len(fault.braked) < repeats and fault.discarded < 10 * repeats:
                    fault.measure(stack)
                yield fault
        if crossings:
            crossings.close()


def quantile(values: list[float], share: float) -> float:
    """The smallest value that at least this share of the values does not exceed."""
    return sorted(values)[max(0, math.ceil(share * len(values)) - 1)]


def rows(quick: bool) -> list[Row]:
    """One row per fault for the table of all benchmarks."""
    return [
        at_most(f"{fault.name}: gate brakes", 1e3 * quantile(fault.braked, 0.99), 1e3 * fault.promise, "ms", COMMAND)
        for fault in measured(5 if quick else 30)
    ]


def main() -> None:
    """Print the table of docs/faults.md."""
    parser = argparse.ArgumentParser(prog=COMMAND, description=__doc__)
    parser.add_argument("--quick", action="store_true", help="5 instead of 30 injections of each fault")
    quick = parser.parse_args().quick
    print("| fault | promise [ms] | p50 [ms] | p99 [ms] | max [ms] | moving again after [s], p50 | n | discarded |")
    print("|---|---|---|---|---|---|---|---|")
    for fault in measured(5 if quick else 30):
        braked = [quantile(fault.braked, share) * 1e3 for share in (0.5, 0.99, 1.0)]
        figures = " | ".join(f"{value:.0f}" for value in braked)
        back = quantile(fault.back, 0.5)
        counts = f"{len(fault.braked)} | {fault.discarded}"
        print(f"| {fault.name} | {fault.promise * 1e3:.0f} | {figures} | {back:.1f} | {counts} |", flush=True)


if __name__ == "__main__":
    main()
