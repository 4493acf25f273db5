"""Rendering the film of a run while other runs still go on, once there is a core to spare."""

from __future__ import annotations

from pathlib import Path

from services.cli.stack.children import Child, Children

RECORDING = "recording.npz"


class Studio:
    """Renders at most one film; `folder` is that of the run to show, None for no film."""

    def __init__(self, folder: Path | None, children: Children) -> None:
        """Nothing is started yet."""
        self._folder = folder
        self._children = children
        self._child: Child | None = None

    def start_if_recorded(self) -> None:
        """Starts rendering as soon as the run is recorded; once only."""
        if self._folder is not None and self._child is None and (self._folder / RECORDING).exists():
            self._child = self._children.start(Child("experiment", ["film", str(self._folder)], nice=19))

    @property
    def busy(self) -> bool:
        """Whether it is still rendering."""
        return self._child is not None and self._child.status is None

    @property
    def problem(self) -> str:
        """Why there is no film although it was tried; empty if there is."""
        return "" if self._child is None or self._child.status == 0 else self._child.last_line
