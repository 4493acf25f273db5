"""Helps and lists: units as the sources declare them, no line wider than the terminal, examples that are accepted."""

from __future__ import annotations

import io
import re
import shlex
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import typer
from rich.console import Console

from services.cli import requests
from services.cli.main import commands
from services.cli.param import _listing
from services.controller.parameters import ControllerParameters
from services.wrench.parameters import WrenchParameters
from shared.topics import TOPICS
from tests.services.cli.command import tandem_here
from tests.support.processes import ROOT

WIDTHS = (60, 80, 100)
UNIT = re.compile(r"\[[^\]]+\]")
DOCUMENTS = (
    "README.md",
    "docs/cli.md",
    "docs/deploy.md",
    "docs/security.md",
    "docs/experiment.md",
    "docs/simulation.md",
    "docs/view.md",
)


def leaves(command: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Every command that does something, by the words that name it."""
    inner = getattr(command, "commands", None)
    if inner is None:
        yield path, command
    for name, one in (inner or {}).items():
        yield from leaves(one, (*path, name))


ROOT_COMMAND = typer.main.get_command(commands)
COMMANDS = dict(leaves(ROOT_COMMAND))


def words(text: str) -> str:
    return " ".join(text.split())


@pytest.fixture(params=WIDTHS)
def width(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> int:
    monkeypatch.setenv("COLUMNS", str(request.param))
    return request.param


@pytest.mark.parametrize("path", [(), ("topic",), ("param",), ("run",), *COMMANDS], ids=" ".join)
def test_a_help_has_every_unit_and_name_and_is_no_wider_than_the_terminal(
    path: tuple[str, ...], width: int, capsys: pytest.CaptureFixture[str]
) -> None:
    shown = tandem_here(capsys, *path, "-h")
    assert (shown.returncode, shown.stderr) == (0, "")
    assert max(map(len, shown.stdout.splitlines())) <= width
    said = words(shown.stdout)
    for parameter in getattr(COMMANDS.get(path), "params", ()):
        for name in (*parameter.opts, *parameter.secondary_opts):
            assert name in said
        for unit in UNIT.findall(getattr(parameter, "help", None) or ""):
            assert unit in said, f"{parameter.name}: {unit}"
    assert shown.stdout == tandem_here(capsys, *path, "--help").stdout


def test_the_list_of_topics_has_every_unit_of_every_field(width: int, capsys: pytest.CaptureFixture[str]) -> None:
    lines = tandem_here(capsys, "topic", "list").stdout.splitlines()
    assert max(map(len, lines)) <= width
    start = max(0, lines[0].find("fields"))
    fields = words(" ".join(line[start:] for line in lines))
    for topic in TOPICS:
        assert re.search(rf"^{topic.key}\b", "\n".join(lines), re.MULTILINE)
        for name, kind, _ in topic.message.kinds():
            assert (f"{name} [{kind.unit}]" if kind.unit else name) in fields


@pytest.mark.parametrize("parameters", [ControllerParameters(), WrenchParameters()], ids=["controller", "wrench"])
def test_the_list_of_parameters_has_every_name_unit_and_value(parameters: Any, width: int) -> None:
    console = Console(file=io.StringIO(), width=width)
    with console.capture() as capture:
        console.print(_listing(parameters.table()))
    shown = capture.get()
    assert max(map(len, shown.splitlines())) <= width
    for name, row in parameters.table().items():
        for word in (name, *row["unit"].split(), *row["doc"].split()):
            assert word in shown


def test_what_can_be_broken_is_listed_within_the_terminal(width: int, capsys: pytest.CaptureFixture[str]) -> None:
    shown = tandem_here(capsys, "fault").stdout
    assert max(map(len, shown.splitlines())) <= width
    assert all(name in shown for name in (*requests.TARGETS, *requests.KINDS))


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The commands that were accepted, none of which is carried out."""
    accepted: list[str] = []

    def accepts(path: tuple[str, ...]) -> Callable[..., None]:
        return lambda **_: accepted.append(" ".join(path))

    for path, command in COMMANDS.items():
        monkeypatch.setattr(command, "callback", accepts(path))
    return accepted


def accept(line: str) -> None:
    """Has the parser take a command line, as a shell would hand it over."""
    given = shlex.split(line, comments=True)
    if "&" in given:
        given = given[: given.index("&")]
    ROOT_COMMAND(given[1:], prog_name="tandem", standalone_mode=False)


@pytest.mark.parametrize("path", COMMANDS, ids=" ".join)
def test_the_example_of_a_help_is_accepted(path: tuple[str, ...], asked: list[str]) -> None:
    heading, line = (COMMANDS[path].epilog or "").removeprefix("\b\n").splitlines()
    assert heading == "Example:" and line.startswith(f"  tandem {' '.join(path)}")
    accept(line)
    assert asked == [" ".join(path)]


@pytest.mark.parametrize("document", DOCUMENTS)
def test_every_command_line_of_the_documents_is_accepted(document: str, asked: list[str]) -> None:
    text = (Path(ROOT) / document).read_text(encoding="utf-8")
    lines = re.findall(r"^    (tandem [a-z].*)$", text, re.MULTILINE)
    parts = [part.strip() for line in lines for part in line.split(";") if part.strip().startswith("tandem ")]
    parts = [part for part in parts if not part.startswith("tandem: ")]
    for part in parts:
        accept(part)
    assert len(asked) == len(parts)


def test_the_version_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    shown = tandem_here(capsys, "--version")
    assert re.fullmatch(r"tandem \d+\.\d+\.\d+, Python 3\.\S+\n", shown.stdout)
