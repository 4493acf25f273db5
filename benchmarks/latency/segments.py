"""Processes of one measurement: started, read and ended, so that nothing of one transport runs beside another."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Self

from benchmarks.latency.relay_probe import ROBOT, TWIST_BYTES, WRENCH_BYTES
from tests.support.ports import free_endpoint, free_port

ROOT = Path(__file__).resolve().parents[2]
ROS_PYTHON = "/usr/bin/python3"


class Failed(RuntimeError):
    """A measuring process ended without a result; the text is its own last words."""


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


class Processes(ExitStack):
    """Child processes that are ended together."""

    def __init__(self, python: str = sys.executable, **environment: str) -> None:
        super().__init__()
        self._python = python
        inherited = {name: value for name, value in os.environ.items() if not name.startswith("TANDEM_")}
        self._environment = {**inherited, "PYTHONPATH": str(ROOT), **environment}

    def start(self, *arguments: str, ready: str = "") -> None:
        """Start one and, if a text is given, wait until it has written it.

        Raises:
            Failed: if it ended before.
        """
        process = subprocess.Popen(
            self._command(arguments),
            cwd=ROOT,
            env=self._environment,
            stdout=subprocess.PIPE if ready else subprocess.DEVNULL,
            stderr=subprocess.STDOUT,
            text=True,
        )
        self.callback(_end, process)
        if process.stdout is not None and not any(ready in line for line in process.stdout):
            raise Failed(f"{' '.join(arguments)} ended at once")

    def measure(self, *arguments: str) -> Segment:
        """Run a probe to its end.

        Raises:
            Failed: if it gave no result.
        """
        done = subprocess.run(
            self._command(arguments), cwd=ROOT, env=self._environment, capture_output=True, text=True
        )
        if done.returncode != 0:
            raise Failed(f"{arguments[0]}: {done.stderr.strip().splitlines()[-1:]}")
        result = json.loads(done.stdout.strip().splitlines()[-1])
        return Segment(**result)

    def _command(self, arguments: tuple[str, ...]) -> list[str]:
        return [*([] if arguments[0].startswith("/") else [self._python, "-m"]), *arguments]


def _end(process: subprocess.Popen[str]) -> None:
    process.terminate()
    try:
        process.wait(3.0)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    if process.stdout is not None:
        process.stdout.close()


def chain(rate: float, seconds: float) -> Segment:
    """The real services through a real router."""
    with Processes() as processes:
        return processes.measure(
            "benchmarks.latency.chain_probe", _services(processes), str(rate), str(seconds)
        )


def started() -> float:
    """Time [s] from the first sample of the mock robot to the first command that its gate executes."""
    with Processes() as processes:
        probe = "benchmarks.latency.chain_probe"
        return processes.measure(probe, _services(processes), "100", "0").first_command


def _services(processes: Processes) -> str:
    """Start router, wrench and controller; returns the router's endpoint."""
    endpoint = free_endpoint()
    processes.start("services.router", "--listen", endpoint, ready="listening")
    for service in ("wrench", "controller"):
        processes.start(f"services.{service}", "--connect", endpoint)
    return endpoint


def relay(rate: float, seconds: float) -> Segment:
    """As many hops with nothing in them, through the same router, with payloads of the same sizes."""
    endpoint = free_endpoint()
    hop = "benchmarks.latency.relay"
    with Processes() as processes:
        processes.start("services.router", "--listen", endpoint, ready="listening")
        processes.start(hop, endpoint, f"{ROBOT}/ft", f"{ROBOT}/wrench", str(WRENCH_BYTES), ready="ready")
        processes.start(
            hop, endpoint, f"{ROBOT}/wrench", f"{ROBOT}/twist", str(TWIST_BYTES), f"{ROBOT}/ee", ready="ready"
        )
        return processes.measure("benchmarks.latency.relay_probe", endpoint, str(rate), str(seconds))


def ros(rate: float, seconds: float) -> Segment:
    """As many hops over ROS 1, whose processes talk to each other without a router."""
    port = free_port()
    environment = {"ROS_MASTER_URI": f"http://127.0.0.1:{port}", "ROS_IP": "127.0.0.1"}
    with Processes(ROS_PYTHON, **environment) as processes:
        processes.start("/usr/bin/rosmaster", "--core", "-p", str(port))
        processes.start("benchmarks.latency.ros_relay", "ft", "wrench", "wrench", ready="ready")
        processes.start("benchmarks.latency.ros_relay", "wrench", "twist", "twist", ready="ready")
        return processes.measure("benchmarks.latency.ros_probe", str(rate), str(seconds))


def ros_missing() -> str:
    """Why ROS 1 cannot be measured here; empty if it can."""
    probe = "import rospy, geometry_msgs.msg"
    if not Path("/usr/bin/rosmaster").exists():
        return "no /usr/bin/rosmaster (Debian: python3-rosmaster)"
    if subprocess.run([ROS_PYTHON, "-c", probe], capture_output=True).returncode != 0:
        return f"{ROS_PYTHON} has no rospy (Debian: python3-rospy python3-geometry-msgs)"
    return ""
