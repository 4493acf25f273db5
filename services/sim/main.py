"""The simulated robot as a process."""

from __future__ import annotations

from collections.abc import Sequence

from services.sim.parameters import SimParameters
from services.sim.simulator import Simulator
from shared.process import run


def main(arguments: Sequence[str] | None = None) -> int:
    """Run until SIGTERM; returns the exit status."""
    return run(Simulator, SimParameters, "sim", None if arguments is None else list(arguments))
