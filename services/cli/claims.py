"""What an experiment found, as tables on the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rich.table import Table
from rich.text import Text


def claims_table(claims: Sequence[dict[str, Any]]) -> Table:
    """Claims as the experiment's judge wrote them, under a heading per run: claim, figure, limit, pass or fail."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    for name in ("claim", "measured", "required", ""):
        table.add_column(name, overflow="fold")
    last = None
    for claim in claims:
        if claim["run"] != last:
            table.add_row(*([] if last is None else [""]))
            table.add_row(Text(claim["run"], style="bold"))
            last = claim["run"]
        mark = Text("pass", style="green") if claim["passed"] else Text("FAIL", style="bold red")
        table.add_row(Text(f"  {claim['short']}"), claim["figure"], claim["limit"], mark)
    return table


def figures_table(found: dict[str, Any]) -> Table:
    """A table as the experiment's report wrote it (`title`, `head`, `rows`): names left, figures right."""
    table = Table(
        box=None, pad_edge=False, header_style="bold", title=f"\n{found['title']}", title_justify="left"
    )
    for number, name in enumerate(found["head"]):
        table.add_column(name, justify="right" if number else "left", vertical="bottom", overflow="fold")
    for row in found["rows"]:
        table.add_row(*row)
    return table
