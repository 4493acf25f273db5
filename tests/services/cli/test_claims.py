"""What an experiment found, on the terminal."""

from __future__ import annotations

import io

from rich.console import Console

from services.cli.claims import figures_table


def test_a_table_of_figures_has_its_title_its_head_and_every_cell() -> None:
    console = Console(file=io.StringIO(), width=80)
    console.print(
        figures_table(
            {
                "title": "Runs side by side",
                "head": ["run", "done after"],
                "rows": [["certified-omni", "63 s"], ["paper-omni", "9 s"]],
            }
        )
    )
    assert isinstance(console.file, io.StringIO)
    lines = [line.strip() for line in console.file.getvalue().splitlines() if line.strip()]
    assert lines == [
        "Runs side by side",
        "run             done after",
        "certified-omni        63 s",
        "paper-omni             9 s",
    ]
