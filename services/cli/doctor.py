"""`tandem doctor`: whether this machine has what a stack needs, line by line, and what to do about what it lacks."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import typer
from rich.console import Console
from rich.text import Text

from services.cli.common import DEFAULT_ROBOT, AsJson, Robot
from services.cli.extras import lacking
from services.cli.health import machine
from services.cli.health.machine import Finding
from services.cli.listing import Listing, show_json
from services.cli.ports import PAGE
from shared.processes import CLI, EXPERIMENT, FURTHER, PROCESSES, STACK, process_named
from shared.wire.credentials import Credentials
from shared.wire.endpoint import DEFAULT_ENDPOINT, BusError, port_of

USUAL = {process_named(name).extra for name in (*STACK, *FURTHER, EXPERIMENT.name, CLI.name)} - {""}
"""Extras of what the usual use starts: `tandem up`, `tandem run`."""
LONGEST = 5.0  # [s] that Docker may take to answer
STYLES = {"ok": "green", "warn": "yellow", "missing": "red"}


def doctor(as_json: AsJson = False, robot: Robot = DEFAULT_ROBOT) -> None:
    """Look at this machine: what a stack needs, and what to do about what is missing; exit status 1 if it is."""
    found = list(findings(robot))
    missing = [finding for finding in found if finding.state == "missing"]
    if as_json:
        show_json({"good": not missing, "checks": [vars(finding) for finding in found]})
    else:
        shown = Listing("check", "", "found", "what to do")
        for finding in found:
            state = Text(finding.state, style=STYLES[finding.state])
            shown.add(finding.check, state, finding.said, finding.remedy)
        Console().print(shown)
    if missing:
        raise typer.Exit(1)


def findings(robot: str) -> Iterator[Finding]:
    """Everything that is looked at."""
    yield machine.cores()
    yield machine.load()
    yield machine.clock()
    yield machine.port("router", port_of(DEFAULT_ENDPOINT))
    yield machine.port("viewer", PAGE)
    yield machine.disk(Path("runs"))
    yield python()
    yield from extras()
    yield machine.film()
    yield docker()
    yield machine.ros()
    yield certificate(robot)
    yield from machine.stacks()


def python(version: tuple[int, int] = sys.version_info[:2]) -> Finding:
    """Whether Python is one that the simulation runs with."""
    said, values = f"Python {platform.python_version()}", {"version": platform.python_version()}
    if version == (3, 11):
        return Finding("Python", "ok", said, values=values)
    return Finding("Python", "warn", said, "the simulation's physics has wheels for 3.11 only; all else runs", values)


def extras(lacks: Callable[[str], list[str]] = lacking) -> list[Finding]:
    """Packages of each process that are not installed."""
    needed: dict[str, list[str]] = {}
    for process in PROCESSES:
        if process.extra:
            needed.setdefault(process.extra, []).append(process.name)
    found = []
    for extra, processes in needed.items():
        if packages := lacks(extra):
            said = f"{', '.join(packages)} not installed, for {', '.join(processes)}"
            values, remedy = {"extra": extra, "lacks": packages}, f"pip install '.[{extra}]' in its checkout"
            found.append(Finding("packages", "missing" if extra in USUAL else "warn", said, remedy, values))
    return found or [Finding("packages", "ok", "all that the processes need", values={"lacks": []})]


def docker() -> Finding:
    """Docker's engine and compose; only the containers need them."""
    remedy = "only the containers need it (docs/deploy.md): install Docker with its compose plugin"
    if shutil.which("docker") is None:
        return Finding("Docker", "warn", "not installed", remedy)
    engine = _said("docker", "version", "--format", "{{.Server.Version}}")
    compose = _said("docker", "compose", "version", "--short")
    values = {"engine": engine or None, "compose": compose or None}
    said = f"engine {engine or 'does not answer'}, compose {compose or 'is missing'}"
    if engine and compose:
        return Finding("Docker", "ok", said, values=values)
    todo = "install its compose plugin" if engine else "start its engine, or join the group docker"
    return Finding("Docker", "warn", said, f"{todo}: only the containers need it", values)


def _said(*command: str) -> str:
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=LONGEST, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return done.stdout.strip() if done.returncode == 0 else ""


def certificate(robot: str) -> Finding:
    """The certificate that the environment names, and when it ends."""
    folder = os.environ.get("TANDEM_SECURE", "")
    if not folder:
        return Finding(
            "certificate", "ok", "none named (TANDEM_SECURE): for stacks on this machine, or an open network"
        )
    try:
        credentials = Credentials.given(robot)
        assert credentials is not None
        own = credentials.own()
    except BusError as problem:
        return Finding("certificate", "missing", str(problem), "make it with `tandem keys`, or unset TANDEM_SECURE")
    said, values = f"{own.name} in {folder}, valid until {own.end}", {"name": own.name, "ends": own.end}
    if own.ends_soon(time.time()):
        return Finding("certificate", "warn", said, "make it anew with `tandem keys FOLDER`", values)
    return Finding("certificate", "ok", said, values=values)
