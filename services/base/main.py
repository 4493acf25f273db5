"""The base's admittance as a process."""

from __future__ import annotations

from collections.abc import Sequence

from services.base.base import Base
from services.base.parameters import BaseParameters
from shared.loop.process import run


def main(arguments: Sequence[str] | None = None) -> int:
    """Run until SIGTERM; returns the exit status."""
    return run(Base, BaseParameters, "base", arguments)
