"""A service as a process: settings, bus, loop, signals and exit status."""

from __future__ import annotations

import gc
import signal
import sys
import threading
import time
from collections.abc import Callable, Sequence
from typing import TypeVar

from shared.clock import SteadyClock, seconds
from shared.loop.config import Misconfigured, Settings, complain, settings
from shared.loop.door import SECOND, Door, Occupied
from shared.loop.healthy import tell
from shared.loop.runner import Runner
from shared.parameters import Parameters, Refused
from shared.processes import LINKED, process_named
from shared.service import Service
from shared.topics import ROBOT
from shared.wire.credentials import Credentials
from shared.wire.endpoint import BusError, check_endpoint
from shared.wire.links import NoLinks, links_of
from shared.wire.publisher import Publisher
from shared.wire.renewal import Lost, Renewal
from shared.wire.zenoh import ZenohBus

P = TypeVar("P", bound=Parameters)

COLLECT_EVERY = 1.0
"""Time [s] between two collections of garbage; a step leaves next to none."""
LOOK_EVERY = 0.5  # [s] between two looks for another one of this kind


class StopRequest:
    """Set by SIGTERM and SIGINT, and by nothing else."""

    def __init__(self) -> None:
        self.requested = False
        self.wake = threading.Event()
        for number in (signal.SIGTERM, signal.SIGINT):
            signal.signal(number, self._on_signal)

    def _on_signal(self, _number: int, _frame: object) -> None:
        # Only a flag: setting the event here would deadlock if the signal interrupts the event's own methods. The
        # loop looks at it at least as often as health is due.
        self.requested = True


def run(make: Callable[[P], Service], parameters: type[P], name: str, arguments: Sequence[str] | None = None) -> int:
    """Run a service until SIGTERM or SIGINT.

    Returns:
        Exit status: 0 after a signal; with one line on standard error 2 after a bad configuration, 3 if another one of
        its kind is there.
    """
    stop = StopRequest()
    try:
        chosen = settings(name, parameters, arguments)
        check_endpoint("--connect", chosen.connect)
        service = make(chosen.parameters)
    except (Misconfigured, Refused, BusError) as problem:
        return complain(name, problem)
    try:
        return _run(service, chosen, name, stop)
    finally:
        service.close()


def _run(service: Service, chosen: Settings, name: str, stop: StopRequest) -> int:
    """Connect the service, and run it until it is told to stop."""
    try:
        row = process_named(name)
        own, credentials = row.publisher, Credentials.of(chosen.secure, chosen.robot, row.known_as)
        links = links_of(own, LINKED, chosen.links, chosen.robot, chosen.connect)
        told = told_waiting(name, chosen.connect, stop)
        bus = ZenohBus(chosen.robot, chosen.connect, told, links, own == ROBOT, credentials)
    except (Misconfigured, NoLinks, Refused) as problem:
        return complain(name, problem)
    except BusError as problem:
        return 0 if stop.requested else complain(name, problem)
    publisher = Publisher(bus, SteadyClock())
    door = Door(bus, row.known_as, publisher.session, f"as {chosen.robot} on {chosen.connect}")
    try:
        door.enter(give_up=lambda: stop.requested)
        bus.link(give_up=lambda: stop.requested)
        if not stop.requested:
            loop = Loop(stop, door.gives_way)
            remark = _remark(credentials, chosen.connect, bus) if credentials else lambda: ""
            how = (stop.wake.set, loop.on_driver, _report, publisher, remark, tell)
            loop.run(Runner(service, bus, SteadyClock(), *how))
    except Occupied as problem:
        _report(f"{name}: {problem}")
        return SECOND
    except BusError as problem:
        return 0 if stop.requested else complain(name, problem)
    finally:
        bus.close()
    return 0


class Loop:
    """Lets a runner work in the thread in which its driving topic arrives, and in the main thread for all else.

    Args:
        stop: ends the loop.
        gives_way: why the loop has to end for another one of its kind, empty if it need not; asked now and then.
    """

    def __init__(self, stop: StopRequest, gives_way: Callable[[], str] = lambda: "") -> None:
        self._stop = stop
        self._gives_way = gives_way
        self._turn = threading.Lock()
        self._runner: Runner | None = None
        self._failure: Exception | None = None
        self._sleeps_until = 0
        self._collects_at = 0.0

    def on_driver(self, behind: bool) -> None:
        """Work because of the driving topic, in the thread of the bus that brought it."""
        with self._turn:
            runner = self._runner
            if runner is None:
                return
            try:
                runner.poll(behind)
                self._collect()
                sooner = runner.next_deadline() < self._sleeps_until
            except Exception as problem:
                self._runner, self._failure, sooner = None, problem, True
        if sooner:
            self._stop.wake.set()

    def run(self, runner: Runner) -> None:
        """Poll the runner whenever it is woken or due, until a stop is requested; brake once more whatever ends it.

        Raises:
            Occupied: it had to give way.
        """
        clock, look = SteadyClock(), 0.0
        # What was built until here lives as long as the process: a collector need not walk it. What comes later it
        # walks between two steps instead of in the middle of one.
        gc.collect()
        gc.freeze()
        gc.disable()
        self._runner = runner
        try:
            while not self._stop.requested:
                with self._turn:
                    runner.poll()
                    self._collect()
                    self._sleeps_until = runner.next_deadline()
                left = seconds(self._sleeps_until - clock.now_ns())
                if left > 0:
                    self._stop.wake.wait(left)
                self._stop.wake.clear()
                # What fails in the other thread ends the process as it would here.
                if self._failure is not None:
                    raise self._failure
                if time.monotonic() >= look:
                    look = time.monotonic() + LOOK_EVERY
                    if reason := self._gives_way():
                        raise Occupied(reason)
        finally:
            with self._turn:
                self._runner = None
                runner.close()
            gc.enable()

    def _collect(self) -> None:
        """Collect garbage if it is time: right after a step, when the next one is as far away as it can be."""
        now = time.monotonic()
        if now >= self._collects_at:
            gc.collect()
            self._collects_at = now + COLLECT_EVERY


def _remark(credentials: Credentials, router: str, bus: ZenohBus) -> Callable[[], str]:
    """What is to be known of a process' certificate, asked now and then; another one is shown at its links, too."""
    renewal, lost = Renewal(credentials), Lost(credentials, router, bus.connected)

    def look() -> str:
        if renewal.renewed():
            bus.link_anew()
        return "; ".join(filter(None, (renewal.remark(), lost.look())))

    return look


def _report(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


def told_waiting(name: str, connect: str, stop: StopRequest) -> Callable[[], bool]:
    """Whether to give up waiting for a router; says once that it waits."""
    told = False

    def give_up() -> bool:
        nonlocal told
        if not told:
            told = True
            _report(
                f"{name}: waiting for a Zenoh router at {connect}; `tandem up` or python -m services.router starts one"
            )
        return stop.requested

    return give_up
