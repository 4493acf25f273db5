"""The controller as a process."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from services.controller.controller import Controller
from services.controller.parameters import ControllerParameters
from shared.clock import SteadyClock
from shared.loop.process import run


def main(arguments: Sequence[str] | None = None) -> int:
    """Run until SIGTERM; returns the exit status."""
    # Every number is checked where it is used; a line on standard error per absurd message would help nobody.
    np.seterr(all="ignore")

    def make(parameters: ControllerParameters) -> Controller:
        return Controller(parameters, SteadyClock().now_ns)

    return run(make, ControllerParameters, "controller", arguments)
