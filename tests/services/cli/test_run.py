"""What an experiment found, on the terminal."""

from __future__ import annotations

import io

from rich.console import Console

from services.cli.run import figures_table
from services.experiment.measure.claim import Table


def test_a_table_of_figures_has_its_title_its_head_and_every_cell() -> None:
    console = Console(file=io.StringIO(), width=80)
    rows = (("certified-omni", "63 s"), ("paper-omni", "9 s"))
    console.print(figures_table(Table("Runs side by side", ("run", "done after"), rows)))
    assert isinstance(console.file, io.StringIO)
    lines = [line.strip() for line in console.file.getvalue().splitlines() if line.strip()]
    assert lines == [
        "Runs side by side",
        "run             done after",
        "certified-omni        63 s",
        "paper-omni             9 s",
    ]
