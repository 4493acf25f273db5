"""What a bridge adds to the way of a sample and of a command: ``python -m benchmarks.bridges [--quick]``.

A far side that speaks as `zenoh-bridge-ros2dds` does, a real bridge of ours, and the robot's keys at its other end. A
sample is timed from its put to `sensor/ft`; a command from its put, with the arm at rest, to the trajectory that starts
the arm. Beside them, in the same run, a bare message over one of the two routers, of which either way crosses two; and,
where `make ros2dds` has built it, the same with a far side in DDS and the real `zenoh-bridge-ros2dds` before it.
"""

from __future__ import annotations

import argparse
import random
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import zenoh

from benchmarks.table import Row, show, shown
from shared.clock import SteadyClock
from shared.messages import Stop, TwistCommand
from shared.robot.profile import Profile
from shared.topics import COMMAND_EE_TWIST, SENSOR_FT, STATE_ROBOT, STOP
from shared.wire.client import Client
from shared.wire.zenoh import ZenohBus
from tests.services.bridge_ros2 import peer
from tests.services.bridge_ros2.far import FarNetwork
from tests.services.bridge_ros2.far_dds import FarDomain
from tests.support import ros2dds
from tests.support.dds import free_domain
from tests.support.ports import free_endpoint, open_session
from tests.support.processes import Processes
from tests.support.wait import eventually

COMMAND = "python -m benchmarks.bridges"
PROFILE = Profile.load("tiago-ros2")
ARM = PROFILE.controllers["arm"]
CREEP = 0.004  # [m/s]: the arm is where it was, for those who are not told that it moved
PATIENCE = 30.0  # [s]
_HEADER = "wrist_right_ft_link"
Network = FarNetwork | FarDomain


class Robot:
    """Tells joint states, odometry and a wrench whose x force counts the samples; notes when each was put [ns]."""

    def __init__(self, network: Network) -> None:
        self.put: dict[int, int] = {}
        self._network = network
        for topic, kind in PROFILE.heard().items():
            network.advertise(topic, kind)
        for topic, kind in PROFILE.commanded().items():
            network.listen(topic, kind)
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        held = [joint for one in (PROFILE.head, PROFILE.gripper) if one for joint in one.joints]
        names = [*PROFILE.arm.joints, *held]
        places = [*PROFILE.arm.home, *[0.0] * len(held)]
        zeros, count = [0.0] * len(names), 0
        while not self._end.wait(0.01):
            header = peer.Header(peer.Time(*divmod(time.time_ns(), 1_000_000_000)), _HEADER)
            if count % 2 == 0:
                joints = peer.JointState(header, names, places, zeros, zeros)
                self._network.publish(PROFILE.joints.topic, joints.serialize())
            count += 1
            wrench = peer.Wrench(peer.Vector3(1e-3 * count, 0.0, 0.0), peer.Vector3(0.0, 0.0, 0.0))
            payload = peer.WrenchStamped(header, wrench).serialize()
            self.put[count] = time.monotonic_ns()
            self._network.publish(PROFILE.wrench.topic, payload)

    def close(self) -> None:
        """Tell no more."""
        self._end.set()
        self._thread.join()


@contextmanager
def _bridged(real: bool) -> Iterator[tuple[Robot, Network, Client]]:
    """A far side, ``real`` if it is one in DDS, a bridge that may move it, and a client at the keys of the contract."""
    own, far = free_endpoint(), free_endpoint()
    with TemporaryDirectory() as folder, Processes(Path(folder)) as processes:
        processes.router(own)
        if real:
            domain = free_domain()
            ros2dds.bridge(processes.start, Path(folder), domain, far)
            side: Network = FarDomain(domain, far)
        else:
            processes.router(far)
            side = FarNetwork(far, "ros2dds")
        settings = (f'far="{far}"', "require_enable=false")
        with closing(side) as network, closing(Robot(network)) as robot:
            options = [part for setting in settings for part in ("--set", setting)]
            processes.start("services.bridge_ros2", "--connect", own, *options)
            with closing(ZenohBus(connect=own)) as bus:
                yield robot, network, Client(bus)


def _samples(robot: Robot, client: Client, seconds: float) -> list[float]:
    """Ways of samples [ms]."""
    ways: list[float] = []
    clock = SteadyClock()

    def heard(received: object) -> None:
        put = robot.put.get(round(1e3 * received.message.force[0]))  # type: ignore[attr-defined]
        if put is not None:
            ways.append(1e-6 * (clock.now_ns() - put))

    sample = client.watch(SENSOR_FT, heard)
    eventually(lambda: sample.latest, PATIENCE, "samples come through the bridge")
    ways.clear()
    time.sleep(seconds)
    return ways[:]


def _commands(network: Network, client: Client, count: int) -> list[float]:
    """Ways of commands that start the arm [ms], forth and back in turns."""
    state = client.watch(STATE_ROBOT)
    eventually(lambda: state.latest, PATIENCE, "the bridge speaks")

    def released() -> bool:
        client.publish(STOP, Stop(False, "a measurement begins"))
        return state.latest is not None and state.latest.message.mode != "stopped"

    ways, received = [], network.received[ARM.topic]
    for number in range(count):
        # A busy machine makes the bridge engage its stop again.
        eventually(released, PATIENCE, "the bridge's stop is released", every=0.1)
        _repeat(client, 0.0, 0.5 + random.random() * 0.02)
        before, begun = len(received), time.monotonic_ns()
        speed = CREEP if number % 2 else -CREEP
        _repeat(client, speed, 0.15, lambda before=before: len(received) > before)
        if len(received) > before:
            ways.append(1e-6 * (time.monotonic_ns() - begun))
    return ways


def _repeat(client: Client, speed: float, seconds: float, until: Callable[[], bool] = lambda: False) -> None:
    """Command a speed [m/s] a hundred times a second for a time, or until something has happened."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        client.publish(COMMAND_EE_TWIST, TwistCommand((speed, 0.0, 0.0), (0.0, 0.0, 0.0), 0.1))
        due = time.monotonic() + 0.01
        while time.monotonic() < due:
            if until():
                return
            time.sleep(0.0002)


def _relayed(seconds: float) -> list[float]:
    """Ways of bare messages of a wrench's size over a router, a hundred a second [ms]."""
    endpoint, ways = free_endpoint(), []
    with TemporaryDirectory() as folder, Processes(Path(folder)) as processes:
        processes.router(endpoint)
        with closing(open_session(endpoint)) as sender, closing(open_session(endpoint)) as reader:

            def heard(sample: zenoh.Sample) -> None:
                put = int.from_bytes(sample.payload.to_bytes()[:8], "little")
                ways.append(1e-6 * (time.monotonic_ns() - put))

            subscriber = reader.declare_subscriber("relay", heard)
            publisher = sender.declare_publisher("relay")
            end = time.monotonic() + seconds
            while time.monotonic() < end:
                publisher.put(time.monotonic_ns().to_bytes(8, "little") + bytes(80))
                time.sleep(0.01)
            subscriber.undeclare()
    return ways


def rows(quick: bool) -> list[Row]:
    """Median and 99th percentile of each way."""
    seconds, count = (3.0, 10) if quick else (20.0, 60)
    relayed = _relayed(seconds)
    told = [("a bare message over one router", relayed)]
    for real in (False, True) if ros2dds.find().is_file() else (False,):
        with _bridged(real) as (robot, network, client):
            name = "bridge_ros2 and zenoh-bridge-ros2dds" if real else "bridge_ros2"
            told.append((f"{name}: sample to sensor/ft", _samples(robot, client, seconds)))
            told.append((f"{name}: command to the arm's trajectory", _commands(network, client, count)))
    return [
        shown(f"{what}, {name}", float(np.quantile(ways, share)), "ms", COMMAND, f"{len(ways)} messages")
        for what, ways in told
        for name, share in (("p50", 0.5), ("p99", 0.99))
    ]


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(prog=COMMAND, description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer messages: a look, not a measurement")
    show(rows(parser.parse_args().quick))


if __name__ == "__main__":
    main()
