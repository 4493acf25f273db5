"""The carrying scenario: what stands in front of the robot besides the floor."""

from __future__ import annotations

import numpy as np

from services.sim.panel import Panel, PanelSpec
from shared.spatial import Array


class Carry:
    """A panel on its supports.

    Attributes:
        panel: the panel.

    Args:
        panel: what it is like.
        step: duration [s] of one physics step.
    """

    def __init__(self, panel: PanelSpec, step: float) -> None:
        self._spec = panel
        self._step = step
        self.reset()

    def reset(self) -> None:
        """Back to the start."""
        self.panel = Panel(self._spec)

    def advance(self) -> None:
        """One physics step."""
        self.panel.step(_NOTHING, _NOTHING, self._step)


_NOTHING: Array = np.zeros(3)
