"""The table of claims on the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rich.table import Table
from rich.text import Text


def claims_table(claims: Sequence[dict[str, Any]]) -> Table:
    """Claims as the experiment's judge wrote them: run, text, figure, limit, passed."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    for name in ("run", "claim", "measured", "required", ""):
        table.add_column(name, overflow="fold")
    last = None
    for claim in claims:
        if last is not None and claim["run"] != last:
            table.add_row()
        mark = Text("pass", style="green") if claim["passed"] else Text("FAIL", style="bold red")
        name = claim["run"] if claim["run"] != last else ""
        table.add_row(Text(name, style="bold"), claim["text"], claim["figure"], claim["limit"], mark)
        last = claim["run"]
    return table
