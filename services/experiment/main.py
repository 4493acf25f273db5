"""Command line of the experiments: `plan`, `play` (one run against a running stack), `film` and `report`."""

from __future__ import annotations

import argparse
import dataclasses
import json
import os
import sys
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from services.experiment.carry.experiment import CARRY
from services.experiment.load.experiment import LOAD
from services.experiment.play.course import ANSWER_WITHIN, Ask, Failed
from services.experiment.play.player import Answered, Experiment
from services.experiment.play.recording import RECORDING, Recording
from services.experiment.report.film import FILM, render
from services.experiment.spec import Play
from shared import topics
from shared.clock import SteadyClock, seconds
from shared.loop.config import Misconfigured, OneLineParser, complain, robot_name, service_parser
from shared.loop.process import StopRequest
from shared.loop.runner import Runner
from shared.parameters import Refused
from shared.wire.bus import Bus, NoReply
from shared.wire.client import Client
from shared.wire.subscription import Inlet
from shared.wire.zenoh import BusError, ZenohBus

NAME = "experiment"
PLAYS = {play.name: play for play in (LOAD, CARRY)}
INCOMPLETE = (
    "incomplete.npz"  # what was recorded of a run that was not played to the end: nothing is judged by it
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command.

    Returns:
        0 when done and every claim holds, and after a signal; 1 when the experiment could not be completed or a claim
        fails, 2 with one line on a bad option.
    """
    try:
        options = _parser().parse_args(arguments)
        commands: dict[str, Callable[[argparse.Namespace], int]] = {
            "plan": _plan,
            "play": _play,
            "film": _film,
            "report": _report,
        }
        return commands[options.command](options)
    except (Misconfigured, BusError, ValueError, FileNotFoundError) as problem:
        return complain(NAME, problem)


def _parser() -> argparse.ArgumentParser:
    parser = OneLineParser(prog=f"python -m services.{NAME}", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True, metavar="plan|play|film|report")
    plan = commands.add_parser("plan", help="print runs and the settings that each needs, as JSON")
    play = commands.add_parser("play", help="play one run against the running stack and record it")
    for command in (plan, play):
        command.add_argument("experiment", choices=PLAYS)
    plan.add_argument("--run", action="append", default=[], metavar="NAME", help="this one, instead of all")
    shared = service_parser(NAME)
    for option in ("--robot", "--connect"):
        play.add_argument(option, default=shared.get_default(option[2:]))
    play.add_argument("--run", required=True, metavar="NAME", help="as in the plan")
    play.add_argument("--out", type=Path, required=True, help="folder to put the recording into")
    play.add_argument("--json", action="store_true", help="progress as JSON, one object per line")
    film = commands.add_parser("film", help="render a film of a recorded run")
    film.add_argument("folder", type=Path, help="folder of the run's recording")
    report = commands.add_parser("report", help="judge the recordings in a folder and write its page")
    report.add_argument("folder", type=Path)
    report.add_argument(
        "--ran", action="append", default=[], metavar="TEXT", help="how it was run, for the page"
    )
    return parser


def _plan(options: argparse.Namespace) -> int:
    play = PLAYS[options.experiment]
    runs = [play.run_named(name) for name in options.run] or play.runs
    print(
        json.dumps(
            {
                "runs": [dataclasses.asdict(run) for run in runs],
                "duration": play.duration,
                "film": play.filmed if play.filmed in {run.name for run in runs} else runs[0].name,
            }
        )
    )
    return 0


def _film(options: argparse.Namespace) -> int:
    problem = render(options.folder, _played(options.folder).film_data)
    print(f"no film: {problem}" if problem else options.folder / FILM)
    return 1 if problem else 0


def _report(options: argparse.Namespace) -> int:
    folder: Path = options.folder
    recorded = sorted(path.parent for path in folder.glob(f"*/{RECORDING}"))
    if not recorded:
        raise FileNotFoundError(f"{folder}: no recording of any run")
    report = _played(recorded[0]).report(folder, options.ran)
    for claim in report.claims:
        print(
            f"{'pass' if claim.passed else 'FAIL'}  {claim.run}: {claim.text}: {claim.figure} ({claim.limit})"
        )
    for problem in report.problems:
        print(f"note  {problem}")
    print(report.index)
    return 0 if all(claim.passed for claim in report.claims) and not report.unfinished else 1


def _played(folder: Path) -> Play:
    """The experiment that was recorded in the folder of a run."""
    name = Recording.load(folder / RECORDING).meta.get("experiment")
    if name not in PLAYS:
        raise ValueError(f"{folder / RECORDING}: of experiment {name!r}, known are {', '.join(PLAYS)}")
    return PLAYS[name]


def _play(options: argparse.Namespace) -> int:
    stop = StopRequest()
    play = PLAYS[options.experiment]
    run = play.run_named(options.run)
    options.out.mkdir(parents=True, exist_ok=True)
    try:
        bus = ZenohBus(robot_name(options.robot), options.connect, give_up=lambda: stop.requested)
    except BusError:
        if stop.requested:
            return 0
        raise
    try:
        client = Client(bus)
        experiment = play.experiment(
            run, bus, client.clock, lambda ask, answered: _ask_aside(client, ask, answered)
        )
        progress = _Progress(options.json, client.watch(topics.TASK_STATUS))
        reason = _conduct(experiment, bus, stop, progress)
        if stop.requested:
            # A broken-off run proves nothing, and writing a long recording takes longer than a signal allows.
            return 0
        recording = experiment.recording(
            date=time.strftime("%Y-%m-%d %H:%M"),
            bus=f"Zenoh, router at {options.connect}",
            cores=os.cpu_count(),
        )
        recording.save(options.out / (INCOMPLETE if reason else RECORDING))
    finally:
        bus.close()
    if reason:
        print(f"{NAME}: {run.name}: {reason}", file=sys.stderr, flush=True)
    return 1 if reason else 0


def _conduct(experiment: Experiment, bus: Bus, stop: StopRequest, progress: _Progress) -> str:
    """Runs the loop until the end; returns why it failed, empty if it did not."""
    clock = SteadyClock()
    runner = Runner(experiment, bus, clock, wake=stop.wake.set)
    while not (stop.requested or experiment.finished):
        left = seconds(runner.next_deadline() - clock.now_ns())
        if left > 0:
            stop.wake.wait(left)
        stop.wake.clear()
        try:
            runner.poll()
        except Failed as problem:
            return str(problem)
        progress.show(experiment)
    return ""


def _ask_aside(client: Client, ask: Ask, answered: Answered) -> None:
    """Asks in a thread of its own, so that targets keep going out while the answer takes its time."""

    def wait() -> None:
        try:
            answered(client.ask(ask.query, ask.request, ask.duration + ANSWER_WITHIN))
        except (NoReply, Refused) as problem:
            answered({"ok": False, "error": str(problem)})

    threading.Thread(target=wait, name=f"ask {ask.query.key}", daemon=True).start()


class _Progress:
    """Says what happens: phase, time on the protocol's clock, events; as text for people or JSON for programs.

    The JSON has the task's reason too, which changes with every centimetre: programs can choose when to show it.
    """

    def __init__(self, as_json: bool, task: Inlet) -> None:
        self._as_json = as_json
        self._task = task
        self._said: tuple[Any, ...] = ()

    def show(self, experiment: Experiment) -> None:
        """Prints a line when something has changed."""
        course = experiment.course
        elapsed = course.elapsed(experiment.now())
        event = course.events[-1] if course.events else None
        if self._as_json:
            clock = None if elapsed is None else round(elapsed, 1)
            # Before the protocol's clock starts the task waits for nothing but its start.
            task = None if clock is None else self._task.latest
            reason = task.message.reason if task else ""
            said: tuple[Any, ...] = (course.phase, clock, event, reason)
            line = json.dumps(
                {
                    "phase": course.phase,
                    "elapsed": clock,
                    "event": event.name if event else "",
                    "reason": reason,
                }
            )
        else:
            said = (course.phase, event)
            line = f"{0.0 if elapsed is None else elapsed:5.1f} s  {course.phase}" + (
                f" ({event.name} {event.detail})" if event else ""
            )
        if said != self._said:
            print(line, flush=True)
            self._said = said
