"""The wrench service as a process."""

from __future__ import annotations

from collections.abc import Sequence

from services.wrench.parameters import WrenchParameters
from services.wrench.wrench import Wrench
from shared.loop.files import default_folder
from shared.loop.process import run


def main(arguments: Sequence[str] | None = None) -> int:
    """Run until SIGTERM; returns the exit status."""

    def make(parameters: WrenchParameters) -> Wrench:
        return Wrench(parameters, default_folder())

    return run(make, WrenchParameters, "wrench", arguments)
