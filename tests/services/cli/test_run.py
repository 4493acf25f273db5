"""What an experiment found, on the terminal."""

from __future__ import annotations

import io
import json
import math
from pathlib import Path
from unittest.mock import Mock

import pytest
import typer
from rich.console import Console

from services.cli.health import machine
from services.cli.run import _conclude, figures_table
from services.experiment.measure.claim import Claim, Table
from services.experiment.report.report import NOT_JUDGED, Report
from shared.schema.valid_json import valid_json
from tests.services.cli.command import tandem_here
from tests.support.ports import free_endpoint


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


def concluded(claims: list[Claim], busy: dict[str, str], failures: list[str]) -> tuple[int, str]:
    """Exit status, and what is printed."""
    report = Report(Path("runs/index.html"), claims, [], [], [], busy)
    console, status = Console(width=100), 0
    with console.capture() as capture:
        try:
            _conclude(console, Path("runs"), Mock(result=lambda: report), failures)
        except typer.Exit as ended:
            status = ended.exit_code
    return status, capture.get()


GOOD, BAD = (Claim("one", f"claim {passed}", "", "1 N", "2 N", passed) for passed in (True, False))


@pytest.mark.parametrize(
    ("claims", "busy", "failures", "status", "said"),
    [
        ([GOOD], [], [], 0, "all 1 claims hold"),
        ([GOOD, BAD], [], [], 1, "1 of 2 claims fail"),
        ([GOOD, BAD], ["one"], [], NOT_JUDGED, "1 of 2 claims not judged: the machine was too busy"),
        ([GOOD, BAD], ["other"], [], 1, "1 of 2 claims fail"),
        ([GOOD], [], ["two: sim ended"], 1, "runs not completed: 1; all 1 claims hold"),
    ],
)
def test_the_verdict_and_its_exit_status(
    claims: list[Claim], busy: list[str], failures: list[str], status: int, said: str
) -> None:
    found, printed = concluded(claims, dict.fromkeys(busy, "late"), failures)
    lines = [line.strip() for line in printed.splitlines()]
    assert (found, lines[-2], lines[-1]) == (status, said, "report: runs/index.html")


def test_for_programs_one_document_is_all_that_is_printed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    report = Report(tmp_path / "index.html", [GOOD], [], [], [], {})
    report.summary.write_text(valid_json({"verdict": report.verdict, "status": 0, "measures": {"one": math.nan}}))
    with pytest.raises(typer.Exit) as ended:
        _conclude(Console(stderr=True), tmp_path, Mock(result=lambda: report), ["two: sim ended"], as_json=True)
    assert ended.value.exit_code == 1
    assert json.loads(capsys.readouterr().out) == {
        "report": str(report.index),
        "failed": ["two: sim ended"],
        "verdict": "all 1 claims hold",
        "status": 1,
        "measures": {"one": None},
    }


def test_a_busy_machine_is_told_in_one_line_before_anything_runs(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    def begun(*_: object) -> None:
        raise typer.Exit(7)

    monkeypatch.setattr("services.cli.run.start_router", begun)
    for idle, lines in ((machine.IDLE, 0), (0.5 * machine.IDLE, 1)):
        monkeypatch.setattr("os.sched_getaffinity", lambda pid: {0, 1})
        monkeypatch.setattr("os.getloadavg", lambda idle=idle: (2.0 - idle, 0.0, 0.0))
        arguments = ("run", "load", "--connect", free_endpoint(), "--out", str(tmp_path))
        done = tandem_here(capsys, *arguments)
        assert done.returncode == 7 and done.stderr.count("\n") == lines
        assert (" processes at work on 2 cores" in done.stderr) == bool(lines)
    done = tandem_here(capsys, *arguments, "--json")
    assert not done.stdout and "load experiment: " in done.stderr
