"""The page beside a stack: a viewer as one more process, whose address is known before it answers there."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from services.cli.extras import lacking
from services.cli.ports import PAGE, taken
from services.cli.stack.children import Child, Children
from shared.processes import VIEWER

_OTHERS = 50
"""Pairs of ports that are tried after the usual one."""

View = Annotated[
    bool,
    typer.Option(
        "--view/--no-view", envvar="TANDEM_VIEW", help="Show it in a browser, opened where there is a desktop."
    ),
]


class Page:
    """A viewer of one robot; whatever becomes of it, the stack goes on.

    Args:
        wanted: whether there is to be one.
        robot, endpoint: of the stack.
        children: end it.
        log: file for what it prints.
    """

    def __init__(self, wanted: bool, robot: str, endpoint: str, children: Children, log: Path | None = None) -> None:
        self._child: Child | None = None
        self._why = ""
        if not wanted:
            return
        if packages := lacking(VIEWER.extra):
            self._why = f"no page: {', '.join(packages)} not installed: pip install '.[{VIEWER.extra}]' in its checkout"
            return
        port = free_pair()
        if port is None:
            self._why = f"no page: no two ports are free from {PAGE} on"
            return
        self._address = f"http://127.0.0.1:{port}/"
        arguments = [*VIEWER.arguments(robot, endpoint), "--port", str(port), "--open"]
        self._child = children.start(Child(VIEWER.name, arguments, log))

    @property
    def said(self) -> str:
        """Where it is, or why it is not; empty if nobody wants it."""
        if self._child is None:
            return self._why
        ended = self._child.how_it_ended()
        return f"no page: the viewer {ended}" if ended else f"see it at {self._address}"


def free_pair() -> int | None:
    """The lower one of two free ports side by side, the usual ones if they are; None if there are none."""
    pairs = range(PAGE, PAGE + 2 * _OTHERS, 2)
    return next((port for port in pairs if not (taken(port) or taken(port + 1))), None)
