"""Size, build and pace of the stack in containers: ``python -m benchmarks.containers [--quick]``, without the camera.

Robot, wrench, controller and base hold a pose at 100 Hz for a minute; late steps are those that the services count
themselves. It needs Docker. On the way: how long a build takes after a change of one service's code, and how long it
is from `up` to a robot that may move.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

from benchmarks.table import Row, at_most, show
from shared.topics import HEALTH_RATE
from tests.support.compose import Compose, unusable
from tests.support.processes import ROOT

COMMAND = "python -m benchmarks.containers"
MEASURED = ("sim", "wrench", "controller", "base")
LISTENER = Path(__file__).with_name("late_steps.py")
LATE_LIMIT, MOVING_LIMIT, BUILD_LIMIT = 0.1, 15.0, 30.0  # [%], [s] and [s] aimed at
SIZE_LIMITS = {"tandem-core": 400.0, "tandem-sim": 1200.0}  # [MB]
BUILT_OF = (".env", "docker-compose.yml", ".dockerignore", "deploy", "services", "shared")


def rows(quick: bool) -> list[Row]:
    """Sizes, the time of a build, the time to a robot that may move, and the share of late steps of each service."""
    if why := unusable():
        raise SystemExit(f"{COMMAND}: {why}")
    rebuilt, busy = _rebuilt(), os.getloadavg()[0]
    with Compose("tandem-benchmark") as stack:
        began = time.monotonic()
        stack.do("up", "-d", "router", *MEASURED)
        while stack.tandem("tare").returncode:
            pass
        tared = time.monotonic() - began
        stack.do("run", "-d", "--rm", "tandem", "hold", "0.45", "-0.39", "0.8", "-1.57", "0", "0")
        # What a busy machine has latched on the way would have it stand still.
        stack.tandem("resume")
        count = int(HEALTH_RATE * (10 if quick else 60)) + 1
        load = os.getloadavg()[0]
        late = _late(stack, count)
    note = f"load average {load:.1f} before"
    return [
        *(
            at_most(f"containers: size of {name}", _size(name), most, "MB", COMMAND)
            for name, most in SIZE_LIMITS.items()
        ),
        at_most(
            "containers: build after a change", rebuilt, BUILD_LIMIT, "s", COMMAND, f"load average {busy:.1f} after"
        ),
        at_most("containers: `up` to a tared robot", tared, MOVING_LIMIT, "s", COMMAND, note),
        *(at_most(f"containers: late steps of {name}", late[name], LATE_LIMIT, "%", COMMAND, note) for name in late),
    ]


def _rebuilt() -> float:
    """Time [s] of a build of all images after a change of one service's code, in a copy of what they are built of."""
    with tempfile.TemporaryDirectory() as folder:
        for part in BUILT_OF:
            copy = shutil.copytree if (ROOT / part).is_dir() else shutil.copy
            copy(ROOT / part, Path(folder) / part)
        with Compose("tandem-benchmark", root=Path(folder)) as stack:
            with (Path(folder) / "services" / "base" / "main.py").open("a", encoding="utf-8") as code:
                code.write(f"# changed at {time.time()}\n")
            began = time.monotonic()
            stack.do("build", timeout=600.0)
            return time.monotonic() - began


def _size(image: str) -> float:
    """Size [MB] of an image with all its layers."""
    command = ["docker", "image", "inspect", "-f", "{{.Size}}", image]
    return int(subprocess.run(command, capture_output=True, text=True, check=True).stdout) / 1e6


def _late(stack: Compose, count: int) -> dict[str, float]:
    """Share [%] of each service's steps that were late during so many messages of its health."""
    mount = ("-v", f"{LISTENER}:/opt/tandem/{LISTENER.name}:ro")
    command = ("--entrypoint", "python", "tandem", LISTENER.name, str(count), *MEASURED)
    found: dict[str, float] = json.loads(stack.do("run", "--rm", "-T", *mount, *command, timeout=180.0))
    return found


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(prog=COMMAND, description=__doc__)
    parser.add_argument("--quick", action="store_true", help="ten seconds: a look, not a measurement")
    show(rows(parser.parse_args().quick))


if __name__ == "__main__":
    main()
