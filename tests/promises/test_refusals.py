"""Whatever a process cannot take is refused with one line that says what, and exit status 2."""

from __future__ import annotations

import importlib
import signal
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from shared.processes import PROCESSES, process_named
from tests.conftest import StartProcess

SETTABLE = tuple(process.name for process in PROCESSES if process.settable)

VALUES: dict[str, dict[str, tuple[str, ...]]] = {
    "sim": {
        "ft_rate=3": ("ft_rate is 3",),
        "seed=-1": ("seed is -1",),
        'base_type="tracked"': ("base_type",),
        "ft_noise=[1, 2]": ("ft_noise",),
    },
    "mock": {"rate=3.0": ("rate is 3", "30 to 1000 Hz")},
    "wrench": {
        "lowpass_hz=-1.0": ("lowpass_hz", "0 to 1000 Hz"),
        "stuck_after=0.0": ("stuck_after", "0.02 to 1 s"),
        "noise_bound=[1.0, 1.0]": ("noise_bound",),
        "noise_bound=[0.5, 0.5, 0.5, 0.0, 0.1, 0.1]": ("noise_bound", "1e-06 to 100"),
    },
    "controller": {
        "period=0.5": ("period", "0.001 to 0.2 s"),
        'law="pid"': ("law", "certified", "paper", "stiffness"),
        "contact_reach=[1.0, 1.0]": ("contact_reach",),
        "zones=[{stiffness=10.0, reach=[9.0, 0.1, 0.1]}]": ("zones[0].reach", "0.001 to 5 m"),
    },
    "base": {
        "mass=0.0": ("mass", "1 to 200 kg"),
        "max_linear=1.5": ("max_linear", "0.01 to 1 m/s"),
        'damping_linear="much"': ("damping_linear", "a finite number"),
        "inertia=[1.0, 2.0]": ("inertia",),
    },
    "task": {
        "marker_id=50": ("marker_id", "0 to 49"),
        "marker_id=1.5": ("marker_id", "a whole number"),
        "force_limit=[10.0, 10.0, 0.0]": ("force_limit", "0.1 to 200 N"),
        "gripper_open=0.05": ("gripper_open", "panel_thickness"),
        'compensation="none"': ("compensation", "tare", "payload"),
    },
}
"""Values of parameters that each process refuses, and what its line says; each can stand in a file as well."""
KNOWN = {
    "wrench": "noise_bound",
    "controller": "contact_stiffness",
    "base": "damping_angular",
    "task": "marker_size",
}
"""A parameter that the line about an unknown one names."""
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
            **{("--set", value): says for value, says in VALUES[name].items()},
            ("--set", "none=1"): ("--set: none is no parameter; there are ", KNOWN.get(name, "")),
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
for _name in set(SETTABLE) - {"sim"}:  # whose physics engine announces itself before the bus is opened
    OPTIONS[_name][("--connect", "here")] = ("--connect here", "wanted <protocol>")


@pytest.fixture(autouse=True)
def own_process(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[None]:
    """What a process sets for itself is set back: it is the test runner's process here."""
    for name in ("TANDEM_ROBOT", "TANDEM_CONNECT", "TANDEM_CONFIG"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    kept = {number: signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGINT)}
    with np.errstate():
        yield
    for number, handler in kept.items():
        signal.signal(number, handler)


def refused(name: str, arguments: tuple[str, ...], says: tuple[str, ...], capfd) -> None:
    """The process ends with status 2 and one line, in which all of these are."""
    assert importlib.import_module(f"{process_named(name).module}.main").main(arguments) == 2
    said = capfd.readouterr()
    assert said.out == "" and said.err.startswith(f"{name}: ") and said.err.count("\n") == 1, said
    assert all(part in said.err for part in says), said.err


@pytest.mark.parametrize(
    ("name", "arguments"),
    [(name, arguments) for name, wrong in OPTIONS.items() for arguments in wrong],
    ids=str,
)
def test_one_line_with_status_2(name: str, arguments: tuple[str, ...], capfd) -> None:
    refused(name, arguments, OPTIONS[name][arguments], capfd)


@pytest.mark.parametrize("name", SETTABLE)
def test_of_a_file_the_line_names_file_and_key(name: str, tmp_path: Path, capfd) -> None:
    path = tmp_path / "config.toml"
    for content, says in {
        **{f"[{name}]\n{value}\n": says for value, says in VALUES[name].items()},
        f"[{name}]\nnone = 1\n": ("none is no parameter",),
        "[nobody]\nnone = 1\n": ("[nobody] is no service",),
        f"[{name}\n": ("not TOML",),
    }.items():
        path.write_text(content)
        refused(name, ("--config", str(path)), (f"--config {path}", *says), capfd)


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
