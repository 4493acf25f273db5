"""The tables of docs/experiment.md come from a command."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.carry_table import RUNS, main, markdown
from services.experiment.measure.claim import Table

DOCUMENT = Path(__file__).parents[2] / "docs" / "experiment.md"


def test_a_table_is_printed_as_the_document_has_it() -> None:
    table = Table("Runs", ("", "a", "b"), (("done after", "63 s", "65 s"),))
    assert markdown(table) == "Runs:\n\n|  | a | b |\n| --- | --- | --- |\n| done after | 63 s | 65 s |\n"


def test_the_document_s_table_has_the_runs_that_are_played() -> None:
    assert markdown(Table("", ("", *RUNS), ())).splitlines()[2] in DOCUMENT.read_text().splitlines()


def test_an_unknown_run_is_refused_with_what_there_is(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["certified-legs"])
    assert ended.value.code == 2
    assert "choose LAW-BASE" in capsys.readouterr().err
