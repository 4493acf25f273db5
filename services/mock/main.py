"""The mock robot as a process.

Every bridge has the same files: ``main`` (this one), ``parameters``, ``robot`` (the service between gate and hardware),
``sensors`` (what the hardware says, as messages), ``commands`` (what the gate lets through, to the hardware), and
``names`` where the hardware calls things by other names than the contract.
"""

from __future__ import annotations

from collections.abc import Sequence

from services.mock.parameters import MockParameters
from services.mock.robot import MockRobot
from shared.loop.process import run


def main(arguments: Sequence[str] | None = None) -> int:
    """Run until SIGTERM; returns the exit status."""
    return run(MockRobot, MockParameters, "mock", arguments)
