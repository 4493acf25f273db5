"""What a machine offers to a stack: cores, clock, ports and disk, each judged for itself."""

from __future__ import annotations

import os
import shutil
import socket
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from services.cli import memory
from services.cli.ports import taken
from shared.wire.endpoint import BusError, check_endpoint, port_of

CORES = 2
"""A carry takes one core and a half; with fewer than these, commands come late."""
IDLE = 1.0  # [cores] that other programs should leave
SLEEP, SLEEPS = 0.005, 100  # [s] of each of so many, to see how late the machine wakes a process
LATE = 0.01  # [s]: a period of the chain at its usual rate
COARSE = 1e-6  # [s] of resolution; intervals of milliseconds are told apart
SPACE = 1000.0  # [MB] on the disk: a recording of some minutes, or the runs of an experiment

DRIVERS = tuple(Path(root, "vulkan", "icd.d") for root in ("/etc", "/usr/share", "/usr/local/share"))
"""Where drivers of Vulkan are named."""


@dataclass(frozen=True)
class Finding:
    """One line: what was looked at, how it is, in words, what to do, and the numbers behind it (units in their names).

    ``missing`` is what the usual use needs: to play the experiments and to run a simulated robot.
    """

    check: str
    state: Literal["ok", "warn", "missing"]
    said: str
    remedy: str = ""
    values: dict[str, Any] = field(default_factory=dict)


def cores() -> Finding:
    """Cores that this process may use."""
    count = len(os.sched_getaffinity(0))
    few = count < CORES
    remedy = f"a carry wants {CORES}: play the load experiment with --parallel 1, or take a larger machine"
    return Finding("cores", "warn" if few else "ok", f"{count} to use", remedy if few else "", {"cores": count})


def load() -> Finding:
    """What runs besides, averaged over a minute."""
    busy, count = os.getloadavg()[0], len(os.sched_getaffinity(0))
    late = count - busy < IDLE
    said = f"{busy:.1f} processes at work on {count} cores in the last minute"
    remedy = "what needs time comes late: close what else runs, see: top"
    return Finding("load", "warn" if late else "ok", said, remedy if late else "", {"load_1min": round(busy, 2)})


def clock() -> Finding:
    """The steady clock's resolution, and how late the machine wakes a process that sleeps."""
    resolution = time.get_clock_info("monotonic").resolution
    overshoot = []
    for _ in range(SLEEPS):
        before = time.monotonic()
        time.sleep(SLEEP)
        overshoot.append(time.monotonic() - before - SLEEP)
    worst, usual = max(overshoot), sorted(overshoot)[SLEEPS // 2]
    values = {"resolution_ns": 1e9 * resolution, "overshoot_p50_ms": 1e3 * usual, "overshoot_worst_ms": 1e3 * worst}
    said = f"resolution {1e9 * resolution:g} ns; of {SLEEPS} sleeps the worst ended {1e3 * worst:.1f} ms late"
    if resolution > COARSE:
        return Finding("clock", "warn", said, "intervals of milliseconds need a finer steady clock", values)
    remedy = "commands come late, and the gate brakes for them: close what else runs, or see docs/deploy.md"
    return Finding("clock", "warn" if worst > LATE else "ok", said, remedy if worst > LATE else "", values)


def port(name: str, number: int) -> Finding:
    """Whether a port of the loopback interface is free, and who holds it if not, as far as this user may see."""
    if not taken(number):
        return Finding(f"port {number}", "ok", f"free ({name})", values={"port": number, "holder": None})
    holder = _holder(number)
    values = {"port": number, "holder": holder or None}
    if f"services.{name}" in holder:
        return Finding(f"port {number}", "ok", f"held by {holder}", values=values)
    option = {"router": "--connect tcp/127.0.0.1:PORT", "viewer": "--port PORT"}[name]
    said = f"held by {holder or 'somebody whom this user may not see'}, not by a {name}"
    return Finding(f"port {number}", "warn", said, f"end that, or choose another one with {option}", values)


def _holder(number: int) -> str:
    """Process id and command line of who listens on a TCP port; empty if that cannot be seen."""
    sockets = set()
    for table in ("tcp", "tcp6"):
        try:
            lines = Path("/proc/net", table).read_text().splitlines()[1:]
        except OSError:
            continue
        rows = [line.split() for line in lines]
        sockets |= {f"socket:[{row[9]}]" for row in rows if row[3] == "0A" and row[1].endswith(f":{number:04X}")}
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if any(os.readlink(held) in sockets for held in (process / "fd").iterdir()):
                command = (process / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace").strip()
                return f"process {process.name} ({command[:80]})"
        except OSError:
            continue
    return ""


def disk(folder: Path) -> Finding:
    """Whether results can be written to a folder, and how much of them."""
    there = folder.absolute()
    while not there.is_dir():
        there = there.parent
    free = shutil.disk_usage(there).free / 1e6
    values = {"folder": str(folder), "free_MB": round(free)}
    if not os.access(there, os.W_OK | os.X_OK):
        return Finding("disk", "missing", f"{there} cannot be written", "call tandem elsewhere, or use --out", values)
    said = f"{free / 1e3:.1f} GB free for {folder}"
    remedy = "make room: `make clean` removes runs/, --out and --most name another disk and less"
    return Finding("disk", "ok" if free >= SPACE else "warn", said, remedy if free < SPACE else "", values)


def film(folders: Sequence[Path] = DRIVERS) -> Finding:
    """Whether there is a driver of Vulkan, with which films of experiments are drawn."""
    named = os.environ.get("VK_DRIVER_FILES") or os.environ.get("VK_ICD_FILENAMES") or ""
    there = [name for name in named.split(":") if name]
    there = there or sorted(path.name for folder in folders for path in folder.glob("*.json"))
    values = {"drivers": there}
    if there:
        return Finding("film", "ok", f"driver of Vulkan: {', '.join(there)}", values=values)
    remedy = "apt-get install mesa-vulkan-drivers, or say --no-film"
    return Finding("film", "warn", "no driver of Vulkan, with which films are drawn", remedy, values)


def stacks() -> list[Finding]:
    """The stacks that are remembered: of this user, by `tandem up` and `tandem run`."""
    found = [
        Finding("stack", "ok", f"robot {robot} runs on {endpoint}", values={"robot": robot, "endpoint": endpoint})
        for robot, endpoint in memory.running()
    ]
    found += [
        Finding("stack", "warn", f"{path} is of a command that has ended without a word", f"rm {path}")
        for path in memory.left_behind()
    ]
    return found or [Finding("stack", "ok", "none of yours runs")]


def ros() -> Finding:
    """Whether a ROS that the environment names can be reached; only a bridge needs it."""
    distribution, master = os.environ.get("ROS_DISTRO", ""), os.environ.get("ROS_MASTER_URI", "")
    values = {"distribution": distribution or None, "master": master or None}
    if not distribution and not master:
        return Finding("ROS", "ok", "none in this environment; only the bridge to a real robot needs it", values=values)
    said = f"{distribution or 'ROS_DISTRO is not set'}, master {master or 'not named'}"
    endpoint = master.replace("http://", "tcp/").rstrip("/")
    try:
        check_endpoint("ROS_MASTER_URI", endpoint)
        host = endpoint.removeprefix("tcp/").rpartition(":")[0]
        socket.create_connection((host.strip("[]"), port_of(endpoint)), timeout=1.0).close()
    except BusError:
        remedy = "set ROS_MASTER_URI to http://HOST:11311, and source /opt/ros/DISTRO/setup.bash"
        return Finding("ROS", "warn", said, remedy, values)
    except OSError as problem:
        remedy = "start roscore there, or name the machine that has it in ROS_MASTER_URI"
        return Finding("ROS", "warn", f"{said}: {problem.strerror or problem}", remedy, values)
    return Finding("ROS", "ok" if distribution else "warn", said, "" if distribution else "source setup.bash", values)
