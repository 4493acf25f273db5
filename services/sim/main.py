"""The simulated robot as a process."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from services.sim.parameters import SimParameters
from shared.loop.process import run

if TYPE_CHECKING:
    from services.sim.simulator import Simulator


def main(arguments: Sequence[str] | None = None) -> int:
    """Run until SIGTERM; returns the exit status."""

    def make(parameters: SimParameters) -> Simulator:
        # The physics engine takes its time and announces itself when imported: not before the settings are sound.
        from services.sim.camera.render_process import RenderProcess
        from services.sim.simulator import Simulator

        return Simulator(parameters, RenderProcess)

    return run(make, SimParameters, "sim", arguments)
