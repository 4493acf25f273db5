"""The progress of runs: what each does and why, in one line each, whatever the width and wherever it is printed."""

from __future__ import annotations

import io

import pytest
from rich.console import Console

from services.cli.progress import Progress

TITLE = "certified, omnidirectional base"
WHY = "no marker in sight: is it covered, or out of the picture? Or has somebody taken the panel away meanwhile?"


def printed(terminal: bool, width: int, shown: list[tuple[str, str]]) -> list[str]:
    """The lines that are left on the screen, or were printed."""
    file = io.StringIO()
    console = Console(file=file, force_terminal=terminal, width=width, color_system=None)
    with Progress([TITLE], 60.0, console) as shows:
        for phase, reason in shown:
            shows.show(TITLE, phase, 12.0, "", reason)
    if shows._bars:
        file.truncate(0)
        file.seek(0)
        Console(file=file, width=width).print(shows._bars.get_renderable())
    return file.getvalue().splitlines()


@pytest.mark.parametrize("width", [80, 120])
def test_on_a_terminal_the_reason_is_cut_off_where_the_line_ends(width: int) -> None:
    (line,) = printed(True, width, [("searching", WHY)])
    assert len(line) == width and line.endswith("…")
    assert line.startswith(TITLE) and "12.0 s" in line and "searching: no" in line


def test_elsewhere_a_line_is_printed_for_other_words_and_not_for_other_numbers() -> None:
    shown = [
        ("approaching", "going in, 0.25 m left"),
        ("approaching", "going in, 0.24 m left"),
        ("searching", WHY),
        ("searching", WHY),
        ("searching", ""),
    ]
    assert printed(False, 80, shown) == [
        f" 12.0 s  {TITLE}: approaching: going in, 0.25 m left",
        f" 12.0 s  {TITLE}: searching: {WHY}",
        f" 12.0 s  {TITLE}: searching",
    ]
