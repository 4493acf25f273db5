"""The table of processes agrees with what it is a table of."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from shared.processes import PROCESSES, ROUTER, SERVICES, Process, process_named
from shared.topics import ANYBODY, OPERATOR, PAGE, PARAMETER_QUERIES, QUERIES, TOPICS

ROOT = Path(__file__).parents[2]
NAMED = {process.publisher for process in PROCESSES}

every_process = pytest.mark.parametrize("process", PROCESSES, ids=lambda process: process.name)


def test_every_folder_of_services_has_a_row() -> None:
    folders = {path.parent.name for path in (ROOT / "services").glob("*/__main__.py")}
    assert folders == {process.name for process in PROCESSES}


def test_topics_and_queries_name_processes() -> None:
    assert {name for topic in TOPICS for name in topic.publishers} <= NAMED | {ANYBODY, OPERATOR, PAGE}
    assert {server for query in QUERIES for server in query.servers} <= NAMED
    assert {query.server for query in PARAMETER_QUERIES} <= {row.name for row in PROCESSES if row.settable}


@every_process
def test_its_extra_is_declared(process: Process) -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    if process.extra:
        assert process.extra in extras
        assert process.extra in extras["all"][0].removeprefix("tandem[").removesuffix("]").split(",")


@every_process
def test_the_documentation_says_what_it_does(process: Process) -> None:
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    assert f"| `{process.module}` | {process.does}" in page


def test_the_options_hold_what_the_caller_chose() -> None:
    assert ROUTER.arguments("r", "tcp/127.0.0.1:1") == ["--listen", "tcp/127.0.0.1:1"]
    assert process_named("wrench").arguments("r", "tcp/127.0.0.1:1") == ["--robot", "r", "--connect", "tcp/127.0.0.1:1"]
    assert "there" in process_named("experiment").arguments("r", "e", "there")


def test_the_router_and_the_command_are_no_services() -> None:
    assert not {"router", "cli"} & set(SERVICES)
