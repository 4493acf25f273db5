"""Lists whose words are whole at every width, and documents that every JSON reader takes."""

from __future__ import annotations

import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from services.cli.listing import Listing, say, show_json

WORD = st.text("abc/_[]m<>", min_size=1, max_size=18)
CELL = st.lists(WORD, min_size=1, max_size=6).map(" ".join)


def shown(listing: Listing, width: int) -> list[str]:
    console = Console(width=width)
    with console.capture() as capture:
        console.print(listing)
    return capture.get().splitlines()


@given(st.lists(st.tuples(WORD, CELL, CELL), min_size=1, max_size=4), st.sampled_from((60, 80, 100)))
def test_every_word_is_whole_and_no_line_is_wider(rows: list[tuple[str, str, str]], width: int) -> None:
    listing = Listing("name", "number [m]>", "what")
    for row in rows:
        listing.add(*row)
    lines = shown(listing, width)
    assert max(map(len, lines)) <= width
    there = " ".join(lines).split()
    for row in rows:
        assert all(word in there for cell in row for word in cell.split())


def test_beside_each_other_if_they_fit_and_else_a_block_for_each_row() -> None:
    listing = Listing("key", "age [ms]>", "publisher")
    listing.add("wrench/external", "7", "wrench")
    assert shown(listing, 60) == [
        "key              age [ms]  publisher",
        "wrench/external         7  wrench   ",
    ]
    narrow = [line.rstrip() for line in shown(listing, 24)]
    assert narrow == ["wrench/external", "  age [ms]   7", "  publisher  wrench"]


@pytest.mark.parametrize("terminal", [True, False])
def test_a_line_has_whole_words_on_a_terminal_and_is_one_elsewhere(terminal: bool) -> None:
    console = Console(width=20, force_terminal=terminal, color_system=None)
    with console.capture() as capture:
        say(console, "a limit [m/s] on wrench/external")
    lines = [line.rstrip() for line in capture.get().splitlines()]
    assert lines == (["a limit [m/s] on", "wrench/external"] if terminal else ["a limit [m/s] on wrench/external"])


def test_what_is_no_number_is_null(capsys: pytest.CaptureFixture[str]) -> None:
    show_json({"a": math.nan, "b": [math.inf, 1.5], "c": {"d": (-math.inf, "µ")}})
    assert json.loads(capsys.readouterr().out) == {"a": None, "b": [None, 1.5], "c": {"d": [None, "µ"]}}
