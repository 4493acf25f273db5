"""`tandem run`: a stack per run, the experiment beside it, the report of all runs, everything down again."""

from __future__ import annotations

import json
import os
import sys
import threading
import time
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from services.cli.claims import claims_table, figures_table
from services.cli.common import DEFAULT_ROBOT, Robot
from services.cli.interrupt import stop_event
from services.cli.progress import Progress
from services.cli.refusal import refuse
from services.cli.runs import planned, write_config
from services.cli.stack.children import Child, Children
from services.cli.stack.lane import Lane
from services.cli.stack.plan import DEFAULT_ENDPOINT, ROUTER, Plan, check_port
from services.cli.studio import Studio
from services.cli.up import Router

POLL = 0.1  # [s]
INTERRUPTED = 130

app = typer.Typer(help="Play an experiment with real processes and write its report.")


@app.callback()
def experiments() -> None:
    """Play an experiment with real processes and write its report."""


Out = Annotated[Path | None, typer.Option(help="Folder of the report; default runs/<experiment>-<date>.")]
Parallel = Annotated[int, typer.Option(min=1, max=5, help="Stacks that run side by side.")]
CARRIES = max(1, min(4, (os.cpu_count() or 1) // 2))
"""Carries side by side: on less than two cores for each, commands come late, and the gate brakes for them."""
Film = Annotated[bool, typer.Option(help="Render a film of the scene.")]


@app.command()
def load(
    runs: Annotated[str, typer.Option(help="Names of runs, separated by commas; all if left out.")] = "",
    out: Out = None,
    parallel: Parallel = 2,
    film: Film = True,
    robot: Robot = DEFAULT_ROBOT,
    router: Router = DEFAULT_ENDPOINT,
) -> None:
    """The paper's load experiment under every law; exit status 1 when a claim fails."""
    names = [name.strip() for name in runs.split(",") if name.strip()]
    _run("load", names, out, parallel, film, robot, router)


@app.command()
def carry(
    law: Annotated[str, typer.Option(help="certified, paper or stiffness: that run alone.")] = "",
    base: Annotated[str, typer.Option(help="omni or differential: that run alone.")] = "",
    no_base: Annotated[bool, typer.Option("--no-base", help="The arm alone: that run alone.")] = False,
    runs: Annotated[str, typer.Option(help="Names of runs, LAW-BASE, separated by commas.")] = "",
    out: Out = None,
    parallel: Parallel = CARRIES,
    film: Film = True,
    robot: Robot = DEFAULT_ROBOT,
    router: Router = DEFAULT_ENDPOINT,
) -> None:
    """Robot and person find, lift, carry, turn and set down a panel; exit status 1 when a claim fails."""
    if no_base and base:
        refuse(f"--no-base and --base {base}: choose one")
    if runs and (law or base or no_base):
        refuse("--runs names whole runs: leave --law, --base and --no-base out")
    names = [name.strip() for name in runs.split(",") if name.strip()]
    if law or base or no_base:
        names = [f"{law or 'certified'}-{'none' if no_base else base or 'omni'}"]
    _run("carry", names, out, parallel, film, robot, router)


def _run(
    experiment: str, names: list[str], out: Path | None, parallel: int, film: bool, robot: str, router: str
) -> None:
    """Plays the runs, all if none is named, and writes their report."""
    plan = planned(experiment, names)
    chosen = plan["runs"]
    check_port(router)
    folder = out or Path("runs") / f"{experiment}-{time.strftime('%Y%m%d-%H%M%S')}"
    folder.mkdir(parents=True, exist_ok=True)
    stop = stop_event()
    console = Console()
    console.print(
        f"{experiment} experiment: {len(chosen)} runs of {plan['duration']:.0f} s in real time, {parallel} at a time"
    )
    with Children() as children:
        _router(children, router, folder)
        studio = Studio(folder / plan["film"] if film else None, children)
        failures = _play(experiment, plan, folder, children, stop, (robot, router), parallel, studio)
        console.print(
            "waiting for the film, then judging and drawing" if studio.busy else "judging and drawing"
        )
        while studio.busy and not stop.wait(POLL):
            pass
        if stop.is_set():
            refuse(f"interrupted; what was recorded lies in {folder}", INTERRUPTED)
        report = children.start(Child("experiment", _report_arguments(folder, chosen)))
        while report.status is None and not stop.wait(POLL):
            pass
    for line in [*failures, *([f"no film: {studio.problem}"] if studio.problem else [])]:
        console.print(f"failed: {line}", style="red", highlight=False, soft_wrap=True)
    _conclude(console, folder, report, failures)


def _play(
    experiment: str,
    plan: dict[str, Any],
    folder: Path,
    children: Children,
    stop: threading.Event,
    where: tuple[str, str],
    parallel: int,
    studio: Studio,
) -> list[str]:
    """Plays all runs, `parallel` at a time; returns a line for each that did not complete."""
    robot, router = where
    waiting, duration = list(plan["runs"]), plan["duration"]
    lanes: dict[int, Lane] = {}
    failures = []
    with Progress([run["title"] for run in waiting], duration) as progress:
        while (waiting or lanes) and not stop.wait(POLL):
            for number, lane in list(lanes.items()):
                progress.show(lane.title, lane.phase, lane.elapsed, lane.trouble(), lane.reason)
                if lane.finished():
                    failure = lane.close()
                    progress.end(lane.title, failure)
                    failures += [failure] if failure else []
                    del lanes[number]
            for number in range(parallel):
                if waiting and number not in lanes:
                    run = waiting.pop(0)
                    name = robot if number == 0 else f"{robot}-{number + 1}"
                    stack = Plan(
                        name,
                        router,
                        write_config(run, folder / run["name"] / "config.toml"),
                        further=tuple(run["further"]),
                    )
                    lanes[number] = Lane(experiment, run, stack, folder / run["name"], children)
            if not waiting and (len(lanes) < parallel or not lanes):
                studio.start_if_recorded()  # a core has become free
        for lane in lanes.values():
            lane.close()
    studio.start_if_recorded()
    return failures


def _router(children: Children, endpoint: str, folder: Path) -> None:
    router = children.start(Child(ROUTER, ["--listen", endpoint], folder / f"{ROUTER}.log"))
    deadline = time.monotonic() + 0.3
    while time.monotonic() < deadline:
        if router.status is not None:
            refuse(f"{ROUTER} {router.how_it_ended()}", 1)
        time.sleep(0.02)


def _report_arguments(folder: Path, chosen: list[dict[str, Any]]) -> list[str]:
    arguments = ["report", str(folder), "--ran", f"tandem {' '.join(sys.argv[1:])}"]
    for run in chosen:
        further = "".join(f" --with {service}" for service in run["further"])
        arguments += [
            "--ran",
            f"{run['name']}: tandem up --config {folder}/{run['name']}/config.toml{further}",
        ]
    return arguments


def _conclude(console: Console, folder: Path, report: Child, failures: list[str]) -> None:
    claims = folder / "claims.json"
    if not claims.exists():
        refuse(f"no report: {report.last_line or 'it said nothing'}; recordings and logs are in {folder}", 1)
    found = json.loads(claims.read_text(encoding="utf-8"))
    console.print(claims_table(found["claims"]))
    for table in found["tables"][:1]:
        console.print(figures_table(table))
    for problem in found["problems"]:
        console.print(f"note: {problem}", highlight=False)
    failed = sum(not claim["passed"] for claim in found["claims"]) + len(failures)
    verdict = (
        f"{failed} of {len(found['claims'])} claims fail"
        if failed
        else f"all {len(found['claims'])} claims hold"
    )
    console.print(verdict, style="bold red" if failed else "bold green", highlight=False)
    console.print(f"report: {folder / 'index.html'}", highlight=False, soft_wrap=True)
    if failed:
        raise typer.Exit(1)
