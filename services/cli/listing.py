"""Lists of the commands: tables whose words are whole at every width, and JSON documents for programs."""

from __future__ import annotations

from typing import Any

import typer
from rich.cells import cell_len
from rich.console import Console, ConsoleOptions, RenderResult
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from shared.schema.valid_json import valid_json

GAP = 2  # [characters] between two columns
READABLE = 16  # [characters]: a column of sentences is not narrower; one of numbers is as its widest word


class Listing:
    """A table without lines; where its words do not fit side by side, a block for each row instead.

    Its cells are taken as they are: a unit in brackets is no mark of rich's.

    Args:
        columns: their names; one that ends with > is set to the right.
        title: above it.
        foot: the names of columns stand at the foot of their cells.
    """

    def __init__(self, *columns: str, title: str = "", foot: bool = False) -> None:
        self._columns = columns
        self._title = title
        self._foot = foot
        self._rows: list[list[Text]] = []

    def add(self, *cells: str | Text) -> None:
        """One more row; cells that are left out are empty."""
        self._rows.append([cell if isinstance(cell, Text) else Text(cell) for cell in cells])

    def __bool__(self) -> bool:
        return bool(self._rows)

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        widths = self._widths(options.max_width)
        if widths:
            yield self._table(widths)
            return
        if self._title:
            yield Text(self._title, style="italic")
        for row in self._rows:
            yield from self._block(row)

    def _widths(self, room: int) -> list[int]:
        """Width of each column within so many characters; none if some word would be broken."""
        least, whole = [], []
        for number, name in enumerate(self._columns):
            texts = [name.removesuffix(">"), *(row[number].plain for row in self._rows if number < len(row))]
            whole.append(max(map(cell_len, texts)))
            longest = max((cell_len(word) for text in texts for word in text.split()), default=0)
            least.append(longest if name.endswith(">") else max(longest, min(whole[-1], READABLE)))
        spare = room - sum(least) - GAP * (len(least) - 1)
        more = [wanted - needed for wanted, needed in zip(whole, least, strict=True)]
        share = min(1.0, spare / max(1, sum(more)))
        return [needed + int(share * wanted) for needed, wanted in zip(least, more, strict=True)] if spare >= 0 else []

    def _table(self, widths: list[int]) -> Table:
        title = Text(self._title) if self._title else None
        made = Table(box=None, padding=(0, GAP, 0, 0), pad_edge=False, title=title, title_justify="left")
        for name, width in zip(self._columns, widths, strict=True):
            made.add_column(
                Text(name.removesuffix(">"), style="bold"),
                justify="right" if name.endswith(">") else "left",
                vertical="bottom" if self._foot else "top",
                width=width,
            )
        for row in self._rows:
            made.add_row(*row)
        return made

    def _block(self, row: list[Text]) -> RenderResult:
        if not row:
            yield Text("")
            return
        yield Text(row[0].plain, style=row[0].style or "bold")
        grid = Table.grid(padding=(0, 2))
        for name, cell in zip(self._columns[1:], row[1:], strict=False):
            if cell.plain:
                grid.add_row(Text(name.removesuffix(">")), cell)
        yield Padding(grid, (0, 0, 0, 2))


def say(console: Console, text: str | Text) -> None:
    """Prints a line: on a terminal its words are whole, elsewhere it stays one line."""
    console.print(text if isinstance(text, Text) else Text(text), soft_wrap=not console.is_terminal)


def show_json(document: Any) -> None:
    """Prints one JSON document: finite numbers, null for what is none."""
    typer.echo(valid_json(document, indent=2))
