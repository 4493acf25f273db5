"""Processes of one measurement: started, read and ended, so that nothing of one transport runs beside another."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Self

from benchmarks.latency.relay import ROBOT, TWIST_BYTES, WRENCH_BYTES
from shared.wire.links import NONE, SOCKETS
from tests.support.closed import make
from tests.support.ports import free_endpoint, free_port
from tests.support.processes import Process, Processes

LONGEST = 120.0
"""Time [s] within which a probe has to have ended."""
RELAY, ROS = "benchmarks.latency.relay", "benchmarks.latency.ros"
ROS_PYTHON = "/usr/bin/python3"
_NAME = "robot{}"


@dataclass
class Segment:
    """What one probe measured.

    Attributes:
        latencies: of all samples [us], None where no answer came.
        overruns: by service.
        first_command: time [s] until the robot's gate executed a command.
    """

    latencies: list[float | None] = field(default_factory=list)
    overruns: dict[str, int] = field(default_factory=dict)
    first_command: float = 0.0

    def add(self, other: Segment) -> Self:
        """Append another segment of the same kind."""
        self.latencies += other.latencies
        for name, count in other.overruns.items():
            self.overruns[name] = self.overruns.get(name, 0) + count
        return self

    def quantile(self, share: float) -> float:
        """Quantile [us] over all samples; infinite if it falls among those that were never answered."""
        ordered = sorted(float("inf") if latency is None else latency for latency in self.latencies)
        return ordered[min(len(ordered) - 1, int(share * len(ordered)))]

    @property
    def lost(self) -> float:
        """Share [1] of samples that were never answered."""
        return sum(latency is None for latency in self.latencies) / len(self.latencies)


def _measured(probe: Process) -> Segment:
    """What a probe prints when it ends."""
    assert probe.wait(LONGEST) == 0, probe.output
    return Segment(**json.loads(probe.output.splitlines()[-1]))


@contextmanager
def _started(keys: Path | None = None) -> Iterator[tuple[Processes, str]]:
    """A router, with certificates if there are any, and its endpoint."""
    endpoint = f"tls/127.0.0.1:{free_port()}" if keys else free_endpoint()
    with TemporaryDirectory() as folder, Processes(Path(folder)) as processes:
        robots = ("--robot", _NAME.format(0)) if keys else ()
        router = processes.start("services.router", "--listen", endpoint, *robots, *_secure(keys, "router"))
        router.wait_for_output("listening", LONGEST)
        yield processes, endpoint


def _secure(keys: Path | None, name: str) -> tuple[str, ...]:
    """Options of a process that has a certificate, if there are any."""
    return ("--secure", str(keys / name)) if keys else ()


def chain(rate: float, seconds: float, links: str = NONE) -> Segment:
    """The real services through a real router, or over direct links beside it."""
    return chains(rate, seconds, 1, links)[0]


def chains(
    rate: float, seconds: float, count: int, links: str = NONE, keys: Path | None = None, record: Path | None = None
) -> list[Segment]:
    """As many robots with services of their own at one router, all at the same time.

    Args:
        rate: of each robot's sensor [Hz].
        seconds: that are measured [s].
        count: of robots.
        links: as of `--links`.
        keys: folder of certificates, for a closed network.
        record: folder into which the recorder writes what the first robot and its services say.
    """
    with _started(keys) as (processes, endpoint):
        probes = []
        if record is not None:
            options = ("--robot", _NAME.format(0), "--connect", endpoint, "--out", str(record))
            processes.start("services.recorder", *options).wait_for_output("recording", LONGEST)
        for robot in map(_NAME.format, range(count)):
            for service in ("wrench", "controller"):
                options = ("--robot", robot, "--connect", endpoint, "--links", links, *_secure(keys, service))
                processes.start(f"services.{service}", *options)
            probe = ("benchmarks.latency.chain_probe", robot, endpoint, str(rate), str(seconds), links)
            probes.append(processes.start(*probe, *((str(keys),) if keys else ())))
        return [_measured(probe) for probe in probes]


def linked(rate: float, seconds: float) -> Segment:
    """The real services over direct links."""
    return chain(rate, seconds, SOCKETS)


def recorded(rate: float, seconds: float, folder: Path) -> Segment:
    """The real services over direct links, while all that they say is written into a folder."""
    return chains(rate, seconds, 1, SOCKETS, record=folder)[0]


def closed(rate: float, seconds: float) -> Segment:
    """The real services through a real router, with mutual TLS and access control."""
    with TemporaryDirectory() as folder:
        with redirect_stdout(sys.stderr):
            keys = make(Path(folder) / "keys", "--robot", _NAME.format(0))
        return chains(rate, seconds, 1, keys=keys)[0]


def started() -> float:
    """Time [s] from the first sample of the mock robot to the first command that its gate executes."""
    return chain(100.0, 0.0).first_command


def relay(rate: float, seconds: float) -> Segment:
    """As many hops with nothing in them, through the same router, with payloads of the same sizes."""
    hops = (("ft", "wrench", str(WRENCH_BYTES)), ("wrench", "twist", str(TWIST_BYTES), f"{ROBOT}/ee"))
    with _started() as (processes, endpoint):
        for source, target, *more in hops:
            hop = f"{ROBOT}/{source}", f"{ROBOT}/{target}", *more
            processes.start(RELAY, "hop", endpoint, *hop).wait_for_output("ready")
        return _measured(processes.start(RELAY, "probe", endpoint, str(rate), str(seconds)))


def ros(rate: float, seconds: float) -> Segment:
    """As many hops over ROS 1, whose processes talk to each other without a router."""
    port = free_port()
    environment = {"ROS_MASTER_URI": f"http://127.0.0.1:{port}", "ROS_IP": "127.0.0.1"}
    with TemporaryDirectory() as folder, Processes(Path(folder)) as processes:
        start = partial(processes.start, environment=environment, python=ROS_PYTHON)
        start("/usr/bin/rosmaster", "--core", "-p", str(port))
        for hop in (("ft", "wrench", "wrench"), ("wrench", "twist", "twist")):
            start(ROS, "hop", *hop).wait_for_output("ready")
        return _measured(start(ROS, "probe", str(rate), str(seconds)))


def ros_missing() -> str:
    """Why ROS 1 cannot be measured here; empty if it can."""
    probe = "import rospy, geometry_msgs.msg"
    if not Path("/usr/bin/rosmaster").exists():
        return "no /usr/bin/rosmaster (Debian: python3-rosmaster)"
    if subprocess.run([ROS_PYTHON, "-c", probe], capture_output=True).returncode != 0:
        return f"{ROS_PYTHON} has no rospy (Debian: python3-rospy python3-geometry-msgs)"
    return ""
