"""No control code asks what time of day it is: a wall clock that steps by an hour cannot have an effect."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

from shared.clock import SteadyClock, nanoseconds, seconds
from tests.support.processes import ROOT

CONTROLS = ("shared", "services/base", "services/controller", "services/router", "services/sim", "services/wrench")
DATED = ("certificate.py", "credentials.py", "renewal.py", "log.py")
"""Of `shared/wire`: a certificate ends at a time of day, and a recording says at which it was made."""
COMPARED = ROOT / "shared/robot/bridge/bridge.py"
"""A bridge tells how far a robot's clock is off this machine's; nothing else depends on it."""
SOURCES = [
    path
    for folder in CONTROLS
    for path in sorted((ROOT / folder).rglob("*.py"))
    if (path.parent != ROOT / "shared/wire" or path.name not in DATED) and path != COMPARED
]
WALL_CLOCK = {
    ("time", "time"),
    ("time", "time_ns"),
    ("time", "localtime"),
    ("time", "gmtime"),
    ("datetime", "now"),
    ("datetime", "utcnow"),
    ("datetime", "today"),
    ("date", "today"),
}


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(ROOT)))
def test_nothing_reads_the_wall_clock(path: Path) -> None:
    tree = ast.parse(path.read_text())
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute):
            owner = node.value.attr if isinstance(node.value, ast.Attribute) else getattr(node.value, "id", "")
            assert (owner, node.attr) not in WALL_CLOCK, f"{path}:{node.lineno}"
        if isinstance(node, ast.ImportFrom) and node.module in ("time", "datetime"):
            imported = {(node.module, name.name) for name in node.names}
            assert not imported & WALL_CLOCK, f"{path}:{node.lineno}"


def test_the_steady_clock_never_goes_back() -> None:
    clock = SteadyClock()
    times = [clock.now_ns() for _ in range(10_000)]
    assert times == sorted(times)


@pytest.mark.parametrize("duration", [0.0, 1e-9, 0.01, 1 / 30, 86_400.0])
def test_durations_survive_the_conversion(duration: float) -> None:
    assert seconds(nanoseconds(duration)) == pytest.approx(duration, abs=1e-9)
