"""The wrench service as a process."""

from __future__ import annotations

from collections.abc import Sequence

from services.wrench.parameters import WrenchParameters
from services.wrench.wrench import Wrench
from shared.loop.config import settings
from shared.loop.files import default_folder
from shared.loop.process import run

NAME = "wrench"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run until SIGTERM; returns the exit status."""

    def make(parameters: WrenchParameters) -> Wrench:
        # A folder for each robot: the payload of one of them means nothing to another.
        folder = default_folder() / settings(NAME, WrenchParameters, arguments).robot
        return Wrench(parameters, folder)

    return run(make, WrenchParameters, NAME, arguments)
