"""`tandem run`: a stack per run with its player, the report of all runs, everything down again."""

from __future__ import annotations

import json
import os
import sys
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.text import Text

from services.cli.background import Background, NoResult
from services.cli.common import (
    DEFAULT_ENDPOINT,
    DEFAULT_ROBOT,
    AsJson,
    Links,
    Robot,
    Router,
    check_place,
    example,
    refuse,
    stop_event,
)
from services.cli.extras import need
from services.cli.health import machine
from services.cli.listing import Listing, say, show_json
from services.cli.progress import Progress
from services.cli.stack.children import Children
from services.cli.stack.lane import Lane
from services.cli.stack.page import Page, View
from services.cli.stack.plan import Plan, check_port, write_config
from services.cli.stack.processes import start_router
from services.experiment import experiments
from services.experiment.experiments import EXPERIMENTS
from services.experiment.measure.claim import Table as Figures
from services.experiment.play.course import Run
from services.experiment.play.recording import RECORDING
from shared.processes import EXPERIMENT, STACK, VIEWER

if TYPE_CHECKING:
    from services.experiment.report.report import Report

POLL = 0.1  # [s]
INTERRUPTED = 130  # exit status, as of a shell after Ctrl-C
SPACE = 100.0  # [MB] that a run may take: recording, film and figures
FILM_WITHIN, REPORT_WITHIN = 900.0, 600.0  # [s], on a busy machine

app = typer.Typer(help="Play an experiment with real processes and write its report.")


@app.callback()
def group() -> None:
    """Play an experiment with real processes and write its report."""


Runs = Annotated[str, typer.Option(help="Names of runs, separated by commas; all if left out.")]
Out = Annotated[Path | None, typer.Option(help="Folder of the report; default runs/<experiment>-<date>.")]
Parallel = Annotated[int, typer.Option(min=1, max=5, help="Stacks that run side by side.")]
CARRIES = max(1, min(4, (os.cpu_count() or 1) // 2))
"""Carries side by side: on less than two cores for each, commands come late, and the gate brakes for them."""
Film = Annotated[bool, typer.Option(help="Render a film of the scene.")]


@app.command(epilog=example("tandem run load --runs certified-100"))
def load(
    runs: Runs = "",
    out: Out = None,
    parallel: Parallel = 2,
    film: Film = True,
    robot: Robot = DEFAULT_ROBOT,
    router: Router = DEFAULT_ENDPOINT,
    links: Links = None,
    view: View = True,
    as_json: AsJson = False,
) -> None:
    """The paper's load experiment under every law; exit status 1 when a claim fails, 4 when some cannot be judged."""
    _run("load", _names(runs), out, parallel, film, robot, router, links, view, as_json)


@app.command(epilog=example("tandem run carry --law certified --no-film"))
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
    links: Links = None,
    view: View = True,
    as_json: AsJson = False,
) -> None:
    """Robot and person find, lift, carry, turn and set down a panel; exit status as of `load`."""
    if no_base and base:
        refuse(f"--no-base and --base {base}: choose one")
    if runs and (law or base or no_base):
        refuse("--runs names whole runs: leave --law, --base and --no-base out")
    names = _names(runs)
    if law or base or no_base:
        names = [f"{law or 'certified'}-{'none' if no_base else base or 'omni'}"]
    _run("carry", names, out, parallel, film, robot, router, links, view, as_json)


def _names(runs: str) -> list[str]:
    return [name.strip() for name in runs.split(",") if name.strip()]


def _run(
    name: str,
    names: list[str],
    out: Path | None,
    parallel: int,
    film: bool,
    robot: str,
    router: str,
    links: str | None,
    view: bool,
    as_json: bool,
) -> None:
    """Plays the runs of these names, all that are usual if there are none, and writes their report."""
    experiment = EXPERIMENTS[name]
    try:
        runs = experiment.chosen(names)
    except ValueError as problem:
        refuse(str(problem))
    folder = out or Path("runs") / f"{name}-{time.strftime('%Y%m%d-%H%M%S')}"
    need({EXPERIMENT.name, *STACK, *(service for run in runs for service in run.further)})
    check_place("--out", folder, SPACE * len(runs))
    check_port(router, robot)
    folder.mkdir(parents=True, exist_ok=True)
    stop = stop_event()
    # Standard output is the document's alone.
    console = Console(stderr=as_json)
    if (busy := machine.load()).state != "ok":
        typer.echo(f"tandem: {busy.said}: {busy.remedy}. It goes on", err=True)
    console.print(
        f"{name} experiment: {len(runs)} runs of {experiment.duration:.0f} s in real time, {parallel} at a time"
    )
    studio = Studio([folder / run.name for run in experiment.shown(runs)] if film else [])
    with Children() as children:

        def lane(number: int, run: Run) -> Lane:
            config = write_config(run.settings, folder / run.name / "config.toml")
            plan = Plan(f"{robot}-{number + 1}" if number else robot, router, config, further=run.further, links=links)
            return Lane(name, run, plan, folder / run.name, children)

        start_router(children, router, folder)
        # The robot of the first runs, and of all where one follows the other.
        page = Page(view, robot, router, children, folder / f"{VIEWER.name}.log")
        if page.said:
            console.print(Text(page.said), soft_wrap=True)
        with Progress([run.title for run in runs], experiment.duration, console) as progress:
            failures = _play(runs, lane, parallel, progress, stop, studio)
    studio.start_if_recorded(over=True)
    doing = "waiting for the film, then judging and drawing" if studio.busy else "judging and drawing"
    say(console, f"{doing}; it takes about a minute, and Ctrl-C ends it: the recordings stay")
    while studio.busy and not stop.wait(POLL):
        pass
    commands = [f"tandem {' '.join(sys.argv[1:])}"]
    for run in runs:
        further = "".join(f" --with {service}" for service in run.further)
        commands.append(f"{run.name}: tandem up --config {folder}/{run.name}/config.toml{further}")
    log = folder / "report.log"
    report = Background(experiments.report, folder, commands, log=log, patience=REPORT_WITHIN)
    while report.busy and not stop.wait(POLL):
        pass
    if stop.is_set():
        refuse(f"interrupted; what was recorded lies in {folder}", INTERRUPTED)
    for line in [*failures, *studio.problems()]:
        say(console, Text(f"failed: {line}", style="red"))
    _conclude(console, folder, report, failures, as_json)


def _play(
    runs: Sequence[Run],
    lane: Callable[[int, Run], Lane],
    parallel: int,
    progress: Progress,
    stop: threading.Event,
    studio: Studio,
) -> list[str]:
    """Plays all runs, `parallel` at a time; returns a line for each that did not complete."""
    waiting, failures = list(runs), []
    lanes: dict[int, Lane] = {}
    while (waiting or lanes) and not stop.wait(POLL):
        for number, one in list(lanes.items()):
            progress.show(one.title, one.phase, one.elapsed, one.trouble(), one.reason)
            if one.finished():
                failure = one.close()
                progress.end(one.title, failure)
                failures += [failure] if failure else []
                del lanes[number]
        for number in range(parallel):
            if waiting and number not in lanes:
                lanes[number] = lane(number, waiting.pop(0))
        if not waiting and (len(lanes) < parallel or not lanes):
            studio.start_if_recorded()  # a core has become free
    for one in lanes.values():
        one.close()
    return failures


class Studio:
    """Renders the film while runs that it does not show still go on, once there is a core to spare.

    Args:
        folders: of the runs to show, the first one of which the film is made first; empty for no film.
    """

    def __init__(self, folders: Sequence[Path]) -> None:
        self._folders = folders
        self._work: Background[Path] | None = None

    def start_if_recorded(self, over: bool = False) -> None:
        """Starts rendering as soon as the runs are recorded, once only; of the first one alone if all is over."""
        shown = self._folders[: 1 if over else None]
        if shown and self._work is None and all((folder / RECORDING).exists() for folder in shown):
            log = shown[0] / "film.log"
            self._work = Background(experiments.film, shown[0], log=log, patience=FILM_WITHIN)

    @property
    def busy(self) -> bool:
        """Whether it is still rendering."""
        return self._work is not None and self._work.busy

    def problems(self) -> list[str]:
        """Why there is no film although it was tried."""
        try:
            if self._work is not None:
                self._work.result()
        except NoResult as problem:
            return [f"no film: {problem}"]
        return []


def _conclude(
    console: Console, folder: Path, work: Background[Report], failures: list[str], as_json: bool = False
) -> None:
    try:
        report = work.result()
    except NoResult as problem:
        refuse(f"no report: {problem}; recordings and logs are in {folder}", 1)
    status = 1 if failures else report.status
    if as_json:
        judged = json.loads(report.summary.read_text(encoding="utf-8"))
        show_json({"report": str(report.index), "failed": failures, **judged, "status": status})
        raise typer.Exit(status)
    console.print(_claims(report))
    for figures in report.tables[:1]:
        console.print(figures_table(figures))
    for line in report.problems:
        say(console, f"note: {line}")
    unfinished = f"runs not completed: {len(failures)}; " if failures else ""
    style = {0: "bold green", 1: "bold red"}.get(status, "bold yellow")
    console.print(Text(f"{unfinished}{report.verdict}", style=style))
    say(console, f"report: {report.index}")
    if status:
        raise typer.Exit(status)


MARKS = {"pass": ("pass", "green"), "fail": ("FAIL", "bold red"), "not judged": ("not judged", "yellow")}


def _claims(report: Report) -> Listing:
    """Claims under a heading per run: claim, figure, limit, and how it stands."""
    shown, last = Listing("claim", "measured", "required", ""), None
    for claim in report.claims:
        if claim.run != last:
            shown.add(*([] if last is None else [""]))
            shown.add(Text(claim.run, style="bold"))
            last = claim.run
        shown.add(f"  {claim.short}", claim.figure, claim.limit, Text(*MARKS[report.standing(claim)]))
    return shown


def figures_table(found: Figures) -> Listing:
    """A table of figures: names left, figures right."""
    first, *others = found.head
    shown = Listing(first, *(f"{name}>" for name in others), title=f"\n{found.title}", foot=True)
    for row in found.rows:
        shown.add(*row)
    return shown
