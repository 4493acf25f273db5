"""Progress of several runs: bars on a terminal, a line per change elsewhere."""

from __future__ import annotations

import re
from collections.abc import Sequence
from types import TracebackType

from rich import progress as bars
from rich.console import Console
from rich.markup import escape
from rich.table import Column

from services.cli.listing import say

_NUMBER = re.compile(r"-?\d+(\.\d+)?")


class Progress:
    """One bar per run over the protocol's time; a context manager."""

    def __init__(self, titles: Sequence[str], duration: float, console: Console) -> None:
        """Bars of `duration` [s] on a console, none started."""
        self._console = console
        self._duration = duration
        self._said: dict[str, str] = {}
        self._bars: bars.Progress | None = None
        if self._console.is_terminal:
            self._bars = bars.Progress(
                bars.TextColumn("{task.description}", table_column=Column(max_width=2 * self._console.width // 5)),
                bars.BarColumn(bar_width=12),
                bars.TextColumn("{task.fields[clock]:>9}"),
                # What does not fit into the line is cut off.
                bars.TextColumn(
                    "{task.fields[phase]}", table_column=Column(ratio=1, no_wrap=True, overflow="ellipsis")
                ),
                console=self._console,
                expand=True,
            )
            self._tasks = {
                title: self._bars.add_task(escape(title), total=duration, clock="", phase="[dim]waiting")
                for title in titles
            }

    def __enter__(self) -> Progress:
        """Starts drawing."""
        if self._bars:
            self._bars.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Leaves the last state on the screen."""
        if self._bars:
            self._bars.stop()

    def show(self, title: str, phase: str, elapsed: float | None, trouble: str, reason: str = "") -> None:
        """Shows what a run does now, and why; `trouble` is shown in red."""
        if self._bars:
            clock = "" if elapsed is None else f"{elapsed:4.1f} s"
            why = f"[dim]: {escape(reason)}" if reason else ""
            text = f"[red]{escape(trouble)}" if trouble else escape(phase) + why
            self._bars.update(self._tasks[title], completed=elapsed or 0.0, clock=clock, phase=text)
        else:
            self._say(title, trouble or (f"{phase}: {reason}" if reason else phase), elapsed)

    def end(self, title: str, failure: str) -> None:
        """A run has ended."""
        if self._bars:
            text = f"[red]{escape(failure)}" if failure else "[green]done"
            self._bars.update(self._tasks[title], completed=self._duration, clock="", phase=text)
        else:
            self._say(title, failure or "done", None)

    def _say(self, title: str, text: str, elapsed: float | None) -> None:
        # A line for other words, not for every centimetre in them.
        words = _NUMBER.sub("", text)
        if self._said.get(title) != words:
            self._said[title] = words
            clock = "" if elapsed is None else f"{elapsed:5.1f} s  "
            say(self._console, f"{clock}{title}: {text}")
