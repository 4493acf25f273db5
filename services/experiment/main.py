"""Command line of the experiments: `plan`, `play` (one run against a running stack), `film` and `report`."""

from __future__ import annotations

import argparse
import dataclasses
import json
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from services.experiment import experiments
from services.experiment.experiments import EXPERIMENTS
from services.experiment.play.process import play
from shared.loop.config import Misconfigured, OneLineParser, complain, robot_name, service_parser
from shared.wire.endpoint import BusError

NAME = "experiment"


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command.

    Returns:
        0 when done and every claim holds, and after a signal; 1 when the experiment could not be completed or a claim
        fails, 2 with one line on a bad option.
    """
    try:
        options = _parser().parse_args(arguments)
        return options.carry_out(options)
    except (Misconfigured, BusError, ValueError, FileNotFoundError) as problem:
        return complain(NAME, problem)


def _parser() -> argparse.ArgumentParser:
    parser = OneLineParser(prog=f"python -m services.{NAME}", description=__doc__)
    commands = parser.add_subparsers(required=True, metavar="plan|play|film|report")
    plan = commands.add_parser("plan", help="print runs and the settings that each needs, as JSON")
    plan.set_defaults(carry_out=_plan)
    play = commands.add_parser("play", help="play one run against the running stack and record it")
    play.set_defaults(carry_out=_play)
    for command in (plan, play):
        command.add_argument("experiment", choices=EXPERIMENTS)
    plan.add_argument("--run", action="append", default=[], metavar="NAME", help="this one, instead of all")
    shared = service_parser(NAME)
    for option in ("--robot", "--connect"):
        play.add_argument(option, default=shared.get_default(option[2:]))
    play.add_argument("--run", required=True, metavar="NAME", help="as in the plan")
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


def _plan(options: argparse.Namespace) -> int:
    experiment = EXPERIMENTS[options.experiment]
    runs = experiment.chosen(options.run)
    plan = {
        "runs": [dataclasses.asdict(run) for run in runs],
        "duration": experiment.duration,
        "film": experiment.shown(runs).name,
    }
    print(json.dumps(plan))
    return 0


def _play(options: argparse.Namespace) -> int:
    experiment = EXPERIMENTS[options.experiment]
    compose = partial(experiment.player, experiment.run_named(options.run))
    return play(compose, robot_name(options.robot), options.connect, options.out, options.json)


def _film(options: argparse.Namespace) -> int:
    try:
        print(experiments.film(options.folder))
    except (KeyError, Misconfigured) as problem:
        print(f"no film: {problem}")
        return 1
    return 0


def _report(options: argparse.Namespace) -> int:
    report = experiments.report(options.folder, options.ran)
    for claim in report.claims:
        verdict = "pass" if claim.passed else "FAIL"
        print(f"{verdict}  {claim.run}: {claim.text}: {claim.figure} ({claim.limit})")
    for problem in report.problems:
        print(f"note  {problem}")
    print(report.index)
    return 0 if report.good else 1
