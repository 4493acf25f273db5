"""Progress of several runs: bars on a terminal, a line per change elsewhere."""

from __future__ import annotations

from collections.abc import Sequence
from types import TracebackType

from rich import progress as bars
from rich.console import Console
from rich.markup import escape


class Progress:
    """One bar per run over the protocol's time; a context manager."""

    def __init__(self, titles: Sequence[str], duration: float) -> None:
        """Bars of `duration` [s], none started."""
        self._console = Console()
        self._duration = duration
        self._said: dict[str, str] = {}
        self._bars: bars.Progress | None = None
        if self._console.is_terminal:
            self._bars = bars.Progress(
                bars.TextColumn("{task.description}"),
                bars.BarColumn(bar_width=24),
                bars.TextColumn("{task.fields[clock]:>9}"),
                bars.TextColumn("{task.fields[phase]}"),
                console=self._console,
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

    def show(self, title: str, phase: str, elapsed: float | None, trouble: str) -> None:
        """What a run does now; `trouble` is shown in red."""
        if self._bars:
            clock = "" if elapsed is None else f"{elapsed:4.1f} s"
            text = f"[red]{escape(trouble)}" if trouble else escape(phase)
            self._bars.update(self._tasks[title], completed=elapsed or 0.0, clock=clock, phase=text)
        else:
            self._say(title, trouble or phase, elapsed)

    def end(self, title: str, failure: str) -> None:
        """A run has ended."""
        if self._bars:
            text = f"[red]{escape(failure)}" if failure else "[green]done"
            self._bars.update(self._tasks[title], completed=self._duration, clock="", phase=text)
        else:
            self._say(title, failure or "done", None)

    def _say(self, title: str, text: str, elapsed: float | None) -> None:
        if self._said.get(title) != text:
            self._said[title] = text
            clock = "" if elapsed is None else f"{elapsed:5.1f} s  "
            self._console.print(f"{clock}{title}: {text}", highlight=False, soft_wrap=True)
