"""The panel with the marker on it, as shapes for the renderer."""

from __future__ import annotations

import numpy as np

from services.sim.camera import marker
from services.sim.camera.canvas import Canvas, Colour
from services.sim.camera.view import Scenery
from shared.spatial import Array

FOAM: Colour = (0.55, 0.68, 0.82, 1.0)
PLATE, INK = 0.0001, 0.0002
"""[m] Heights of the marker's white and of its black above the panel: enough for the renderer to tell them apart as
near as the head is."""


class PanelShapes:
    """A box, a white plate and black strips.

    Args:
        canvas: where they are drawn.
        scenery: size of the panel, and its marker.
    """

    def __init__(self, canvas: Canvas, scenery: Scenery) -> None:
        self._canvas = canvas
        self._marker_in_panel = scenery.marker_in_panel
        self._panel = canvas.box(scenery.panel_size, FOAM)
        cell = scenery.marker_size / marker.CELLS
        whole = scenery.marker_size + 2.0 * marker.MARGIN * cell
        plate = canvas.box((whole, whole, PLATE), (1.0, 1.0, 1.0, 1.0))
        # Each part with its place in the marker's frame.
        self._parts = [(plate, np.array((0.0, 0.0, 0.5 * PLATE)))]
        for left, right, lower, upper in marker.strips(scenery.marker):
            strip = canvas.box(((right - left) * cell, (upper - lower) * cell, INK), (0.02, 0.02, 0.02, 1.0))
            centre = np.array((0.5 * (left + right) * cell, 0.5 * (lower + upper) * cell, 0.5 * INK))
            self._parts.append((strip, centre))

    def pose(self, position: Array, rotation: Array, covered: bool) -> None:
        """Put the panel's centre at a position (3,) [m] and rotation (3, 3), with the marker covered or not."""
        self._canvas.place(self._panel, position, rotation)
        turned = rotation.dot(marker.ROTATION)
        centre = position + rotation.dot(self._marker_in_panel)
        for part, place in self._parts:
            if covered:
                self._canvas.hide(part)
            else:
                self._canvas.place(part, centre + turned.dot(place), turned)
