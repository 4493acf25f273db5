"""Command line of the experiments: `settings`, `play` (one run, on a stack made for it), `film`, `report`; and
`run`, which makes a stack that runs already ready for a run, plays it, films and judges it.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from services.experiment import experiments
from services.experiment.experiments import EXPERIMENTS
from services.experiment.play.process import play
from services.experiment.play.recording import RECORDING
from services.experiment.running import ROBOT_WITHIN, as_wanted, playable, set_back
from shared.loop.config import Misconfigured, OneLineParser, complain, config_text, one_line, robot_name, service_parser
from shared.loop.entry import end_at_once
from shared.parameters import Refused
from shared.wire.bus import NoReply
from shared.wire.client import Client
from shared.wire.credentials import Credentials
from shared.wire.endpoint import BusError
from shared.wire.zenoh import ZenohBus

NAME = "experiment"


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command.

    Returns:
        0 when done and every claim holds, and after a signal; 1 when the experiment could not be completed or a claim
        fails, 2 with one line on a bad option, 4 when claims cannot be judged since the machine was too busy.
    """
    try:
        options = _parser().parse_args(arguments)
        return options.carry_out(options)
    except (Misconfigured, BusError, ValueError, OSError) as problem:
        return complain(NAME, problem)


def _parser() -> argparse.ArgumentParser:
    parser = OneLineParser(prog=f"python -m services.{NAME}", description=__doc__)
    commands = parser.add_subparsers(required=True, metavar="settings|play|run|film|report")
    settings = commands.add_parser("settings", help="print the parameters of a run, as a file for --config")
    settings.set_defaults(carry_out=_settings)
    play = commands.add_parser("play", help="play one run against the stack made for it, and record it")
    play.set_defaults(carry_out=_play)
    run = commands.add_parser("run", help="play one run against any running simulation, film it and judge it")
    run.set_defaults(carry_out=_run)
    for command in (settings, play, run):
        command.add_argument("experiment", choices=EXPERIMENTS)
    shared = service_parser(NAME)
    for command in (play, run):
        for option in ("--robot", "--connect"):
            command.add_argument(option, default=shared.get_default(option[2:]))
    for command in (settings, play):
        command.add_argument("--run", required=True, metavar="NAME", help="of the experiment")
    run.add_argument("--run", default="", metavar="NAME", help="the one that is filmed, if left out")
    run.add_argument("--out", type=Path, help="folder of the report; default runs/<experiment>-<date>")
    run.add_argument("--no-film", action="store_true", help="render no film")
    play.add_argument("--out", type=Path, required=True, help="folder to put the recording into")
    play.add_argument("--json", action="store_true", help="progress as JSON, one object per line")
    film = commands.add_parser("film", help="render a film of a recorded run")
    film.set_defaults(carry_out=_film)
    film.add_argument("folder", type=Path, help="folder of the run's recording")
    report = commands.add_parser("report", help="judge the recordings in a folder and write its page")
    report.set_defaults(carry_out=_report)
    report.add_argument("folder", type=Path)
    report.add_argument("--ran", action="append", default=[], metavar="TEXT", help="how it was run, for the page")
    return parser


def _play(options: argparse.Namespace) -> int:
    experiment = EXPERIMENTS[options.experiment]
    compose = partial(experiment.player, experiment.run_named(options.run))
    return play(compose, robot_name(options.robot), options.connect, options.out, options.json)


def _settings(options: argparse.Namespace) -> int:
    print(config_text(EXPERIMENTS[options.experiment].run_named(options.run).settings), end="")
    return 0


def _run(options: argparse.Namespace) -> int:
    experiment = EXPERIMENTS[options.experiment]
    run = playable(experiment, options.run)
    robot = robot_name(options.robot)
    folder = options.out or Path("runs") / f"{experiment.name}-{time.strftime('%Y%m%d-%H%M%S')}"
    recorded = folder / run.name / RECORDING
    recorded.parent.mkdir(parents=True, exist_ok=True)
    bus = ZenohBus(robot, options.connect, credentials=Credentials.given(robot))
    try:
        if NAME in bus.living():
            raise Refused(f"another one is played as {robot} on {options.connect}: wait for its end, or end it first")
        client = Client(bus)
        print("setting the scene back", flush=True)
        set_back(client, ROBOT_WITHIN)
        with as_wanted(client, run):
            status = play(partial(experiment.player, run), robot, options.connect, recorded.parent, as_json=False)
    except (NoReply, Refused) as problem:
        complain(NAME, problem)
        return 1
    finally:
        bus.close()
        end_at_once()
    if status or not recorded.exists():
        return status
    # What comes now has time, and the robot goes on.
    os.nice(19)
    if not options.no_film:
        print("rendering the film", flush=True)
        _film(argparse.Namespace(folder=recorded.parent))
    return _report(argparse.Namespace(folder=folder, ran=[f"{run.name} on a running stack"]))


def _film(options: argparse.Namespace) -> int:
    try:
        print(experiments.film(options.folder))
    except (KeyError, Misconfigured, ValueError, OSError) as problem:
        print(f"no film: {one_line(problem)}")
        return 1
    return 0


def _report(options: argparse.Namespace) -> int:
    report = experiments.report(options.folder, options.ran)
    for claim in report.claims:
        standing = report.standing(claim)
        print(
            f"{'FAIL' if standing == 'fail' else standing}  {claim.run}: {claim.text}: {claim.figure} ({claim.limit})"
        )
    for problem in report.problems:
        print(f"note  {problem}")
    print(report.verdict)
    print(f"report: {report.index}")
    return report.status
