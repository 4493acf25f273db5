"""Whatever a process cannot take is refused with one line that says what, and exit status 2."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from pathlib import Path

import pytest

from shared.parameters import Parameters
from shared.processes import PROCESSES, process_named
from tests.conftest import StartProcess

pytestmark = pytest.mark.usefixtures("as_a_process")

SETTABLE = tuple(process.name for process in PROCESSES if process.settable)

TOGETHER = {
    "controller": {"zones=[{stiffness=10.0, reach=[9.0, 0.1, 0.1]}]": ("zones[0].reach", "0.001 to 5 m")},
    "task": {"gripper_open=0.05": ("gripper_open", "panel_thickness")},
}
"""Assignments that a process refuses although each value alone is of its type and in its range."""


def parameters(name: str) -> Parameters:
    """The parameters of a process, by default."""
    module = importlib.import_module(f"{process_named(name).module}.parameters")
    made: Parameters = getattr(module, "".join(map(str.capitalize, name.split("_"))) + "Parameters")()
    return made


def wrong_values(name: str) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Assignments that a process refuses, for each of its parameters, and what its line says."""
    for key, row in parameters(name).table().items():
        value, bounds = row["value"], (row["min"], row["max"])
        if isinstance(value, bool):
            yield f'{key}="yes"', (key, "true or false")
        elif isinstance(value, str):
            yield f"{key}=1", (key, "wanted ")
        else:
            yield f'{key}="much"', (key,)
        if isinstance(value, list) and value:
            yield f"{key}={value[:-1]}", (key,)
        for bound, beyond in zip(bounds, (-1, 1), strict=True):
            if bound is not None:
                outside = [bound + beyond, *value[1:]] if isinstance(value, list) else bound + beyond
                yield f"{key}={outside}", (f"{key} is ", "allowed is ", f"{bound:g}", row["unit"])
    yield from TOGETHER.get(name, {}).items()


ENDPOINTS = ("7447", "127.0.0.1:7447", "tcp/127.0.0.1", "tcp/127.0.0.1:0", "tcp/127.0.0.1:70000")
OPTIONS: dict[str, dict[tuple[str, ...], tuple[str, ...]]] = {
    "router": {("--listen", where): ("--listen", where, "tcp/127.0.0.1:7447") for where in ENDPOINTS},
    "experiment": {
        ("play", "load", "--out", ".", "--run", "none"): ("none", "certified-100"),
        ("play", "nothing"): ("nothing", "load", "carry"),
        ("report", "/nowhere"): ("/nowhere",),
    },
    **{
        name: {
            ("--set", "none=1"): ("--set: none is no parameter; there are ", next(iter(parameters(name).table()))),
            ("--set", "none"): ("--set none", "wanted"),
            ("--set", "none="): ("--set none=", "not TOML"),
            ("--robot", "two/chunks"): ("--robot 'two/chunks'", "letters, digits"),
            ("--config", "/none.toml"): ("--config /none.toml", "No such file"),
        }
        for name in SETTABLE
    },
}
OPTIONS["wrench"][("--set", 'payload="/none.toml"')] = ("payload", "/none.toml", "No such file")
for _name in ("router", *SETTABLE):
    OPTIONS[_name] |= {(wrong,): (wrong, "See --help") for wrong in ("--no-such-option", "stray")}
for _name in SETTABLE:
    OPTIONS[_name][("--connect", "here")] = ("--connect here", "wanted <protocol>")


def refused(name: str, arguments: tuple[str, ...], says: tuple[str, ...], capfd) -> None:
    """The process ends with status 2 and one line, in which all of these are."""
    assert importlib.import_module(f"{process_named(name).module}.main").main(arguments) == 2
    said = capfd.readouterr()
    assert said.out == "" and said.err.startswith(f"{name}: ") and said.err.count("\n") == 1, said
    assert all(part in said.err for part in says), said.err


@pytest.mark.parametrize(
    ("name", "arguments"), [(name, arguments) for name, wrong in OPTIONS.items() for arguments in wrong], ids=str
)
def test_one_line_with_status_2(name: str, arguments: tuple[str, ...], capfd) -> None:
    refused(name, arguments, OPTIONS[name][arguments], capfd)


@pytest.mark.parametrize("name", SETTABLE)
def test_of_every_parameter_the_line_names_value_and_limit_and_the_file_that_it_stands_in(
    name: str, tmp_path: Path, capfd
) -> None:
    path = tmp_path / "config.toml"
    for assignment, says in wrong_values(name):
        refused(name, ("--set", assignment), ("--set", *says), capfd)
        path.write_text(f"[{name}]\n{assignment}\n")
        refused(name, ("--config", str(path)), (f"--config {path}", *says), capfd)
    for content, part in ((f"[{name}]\nnone = 1\n", "none is no parameter"), (f"[{name}\n", "not TOML")):
        path.write_text(content)
        refused(name, ("--config", str(path)), (f"--config {path}", part), capfd)
    path.write_text("[nobody]\nnone = 1\n")
    refused(name, ("--config", str(path)), (f"--config {path}", "[nobody] is no service"), capfd)


@pytest.mark.parametrize("content", [None, '{ mode: "rou', "{ no_such_key: 1 }"])
def test_of_a_file_of_zenoh_the_router_names_the_file(tmp_path: Path, content: str | None, capfd) -> None:
    path = tmp_path / "router.json5"
    if content is not None:
        path.write_text(content)
    refused("router", ("--config", str(path)), (str(path),), capfd)


@pytest.mark.processes
@pytest.mark.parametrize("name", [process.name for process in PROCESSES])
def test_started_as_users_do_it_says_the_same(name: str, start: StartProcess) -> None:
    arguments, says = next(iter(OPTIONS.get(name, {("--none",): ("--none",)}).items()))
    start(process_named(name).module, *arguments).refuses(*says)
