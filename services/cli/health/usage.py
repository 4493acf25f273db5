"""CPU and memory of the processes of one robot on this machine, as /proc tells them."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from services.cli.common import DEFAULT_ENDPOINT, DEFAULT_ROBOT
from shared.processes import CLI, PROCESSES, ROUTER

_NAMES = {process.module: process.name for process in PROCESSES if process is not CLI}
_TICK = 1.0 / os.sysconf("SC_CLK_TCK")  # [s]
_PAGE = os.sysconf("SC_PAGE_SIZE") / 1e6  # [MB]


@dataclass(frozen=True)
class Usage:
    """One process: its id, CPU [% of a core] since the look before, memory [MB] that it occupies."""

    pid: int
    cpu: float
    memory: float


class UsageMeter:
    """Looks again and again at the processes of a robot that have their router at an endpoint."""

    def __init__(self, robot: str, endpoint: str) -> None:
        self._robot, self._endpoint = robot, endpoint
        self._before: dict[int, tuple[float, float]] = {}

    def look(self) -> dict[str, Usage]:
        """What is used, by name of the process; CPU is none at the first look at it."""
        found, seen = {}, {}
        for folder in Path("/proc").glob("[0-9]*"):
            try:
                command = (folder / "cmdline").read_bytes().decode(errors="replace").split("\0")
                if not (name := module_of(command)):
                    continue
                if of(name, command, _environment(folder)) not in ((self._robot, self._endpoint), ("", self._endpoint)):
                    continue
                # The executable's name, in brackets, may hold anything; what follows it is numbers.
                fields = (folder / "stat").read_text().rpartition(")")[2].split()
                memory = _PAGE * int((folder / "statm").read_text().split()[1])
            except (OSError, IndexError):
                continue  # it has ended meanwhile, or is somebody else's
            pid, now, busy = int(folder.name), time.monotonic(), _TICK * (int(fields[11]) + int(fields[12]))
            then, before = self._before.get(pid, (now, busy))
            seen[pid] = (now, busy)
            found[name] = Usage(pid, 100.0 * (busy - before) / max(now - then, _TICK), memory)
        self._before = seen
        return found


def module_of(command: Sequence[str]) -> str:
    """Name of the process of this project that a command line is of; empty if it is of none."""
    following = dict(pairwise(command))
    return _NAMES.get(following.get("-m", ""), "")


def of(name: str, command: Sequence[str], environment: Mapping[str, str]) -> tuple[str, str]:
    """Robot (none of a router, which is everybody's) and endpoint of a process, by its command line and environment."""
    given = dict(pairwise(command))
    if name == ROUTER.name:
        return "", given.get("--listen", DEFAULT_ENDPOINT)
    robot = given.get("--robot", environment.get("TANDEM_ROBOT", DEFAULT_ROBOT))
    return robot, given.get("--connect", environment.get("TANDEM_CONNECT", DEFAULT_ENDPOINT))


def _environment(folder: Path) -> dict[str, str]:
    parts = (folder / "environ").read_bytes().decode(errors="replace").split("\0")
    return {name: value for name, _, value in (part.partition("=") for part in parts)}
