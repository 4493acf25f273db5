"""``python -m benchmarks.contact.processes``: contacts around the real processes, in real time over a real router.

Router, `services.wrench` and `services.controller` are processes as users start them; the robot with its contact world
is this one. A case in which a declared time (`period`, `delay`) did not hold is outside the guarantee: it is reported
as such and judged apart. Exit status 1 if a case inside the guarantee exceeded a limit, or none was inside.
"""

from __future__ import annotations

import argparse
import itertools
import json
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.contact.cases import Case, Timing
from benchmarks.contact.laws import parameters
from benchmarks.contact.live import LiveRobot, Measured
from benchmarks.contact.measure import OVER
from benchmarks.contact.report import write_csv
from benchmarks.contact.sampling import draw
from shared.wire.client import Client
from shared.wire.zenoh import ZenohBus
from tests.support.ports import free_endpoint
from tests.support.processes import Processes

_RATE = 100.0
_PERIOD, _DELAY = 0.04, 0.06
_ERROR = np.repeat((0.3, 0.02), 3)
_DURATION = 3.0
_PATIENCE = 20.0
_GROUPS = ("soft", "stiff")
_FORMS = ("certified", "certified-rounded")


@dataclass(frozen=True)
class Outcome:
    """One case with one form of the law."""

    group: str
    number: int
    form: str
    measured: Measured

    @property
    def verdict(self) -> str:
        """What the case says about the guarantee."""
        if not self.measured.moved:
            return "did not start"
        late = self.measured.held > _PERIOD + 1e-9 or self.measured.delay > _DELAY
        kept = "kept" if self.measured.peak <= OVER else "OVER"
        return f"{kept}, a declared time did not hold" if late else kept


def live_case(seed: int, group: str, number: int) -> Case:
    """The random case with the timing of the real processes, without lag, and the wrench service's error bound."""
    case = draw(seed, group, number)
    timing = Timing(1.0 / _RATE, 0.0, (0.0, _DELAY), 0.0, 0.0, _PERIOD, _DELAY, 0.0)
    targets = tuple(replace(target, time=index * _DURATION / 3.0) for index, target in enumerate(case.targets))
    return replace(case, timing=timing, targets=targets, error_bound=_ERROR, quiet=_DURATION, duration=_DURATION)


def run_case(robot: LiveRobot, processes: Processes, endpoint: str, case: Case, form: str) -> Measured:
    """A controller process of its own for one case."""
    with processes.start("services.controller", *_arguments(case, form, endpoint)) as controller:
        measured = robot.play(case, _PATIENCE)
        if not controller.running:
            raise RuntimeError(f"the controller ended by itself:\n{controller.output}")
    return measured


def _arguments(case: Case, form: str, endpoint: str) -> list[str]:
    given = parameters(form, case).model_dump(exclude_defaults=True)
    # JSON's numbers, lists and strings are TOML's too.
    settings = (("--set", f"{name}={json.dumps(value)}") for name, value in given.items())
    return ["--connect", endpoint, *itertools.chain(*settings)]


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the cases; returns the exit status."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.contact.processes", description=__doc__)
    parser.add_argument("--cases", type=int, default=50, help="number of cases, forms and sets in turn (default 50)")
    parser.add_argument("--seed", type=int, default=1, help="what the cases are drawn from (default 1)")
    parser.add_argument("--out", type=Path, default=Path("runs/contact"), help="folder (default runs/contact)")
    options = parser.parse_args(arguments)
    console = Console(width=None if sys.stdout.isatty() else 140)
    outcomes: list[Outcome] = []
    endpoint = free_endpoint()
    noise = [f"noise_bound={_ERROR.tolist()}", f"bias_bound={[0.0] * 6}", "tool_mass=0.0"]
    sets = [word for setting in noise for word in ("--set", setting)]
    with tempfile.TemporaryDirectory() as folder, Processes(Path(folder)) as processes:
        processes.router(endpoint)
        processes.start("services.wrench", "--connect", endpoint, *sets)
        bus = ZenohBus(connect=endpoint)
        robot = LiveRobot(Client(bus), _RATE)
        for index in range(options.cases):
            group, form = _GROUPS[index // 2 % 2], _FORMS[index % 2]
            case = live_case(options.seed, group, index // 4)
            measured = run_case(robot, processes, endpoint, case, form)
            outcomes.append(Outcome(group, index // 4, form, measured))
            print(f"{index + 1}/{options.cases} {group} {form}: {outcomes[-1].verdict}", file=sys.stderr)
        bus.close()
    _show(console, outcomes)
    _write(options.out, outcomes)
    return _status(console, outcomes)


def _show(console: Console, outcomes: list[Outcome]) -> None:
    declared = f"declared T {_PERIOD:g} s, d {_DELAY:g} s"
    table = Table(title=f"contacts around the real processes, {_RATE:g} Hz, {declared}")
    for name in ("set", "form"):
        table.add_column(name)
    for name in ("cases", "inside", "over inside", "over outside", "peak p50", "max", "held ms", "delay ms"):
        table.add_column(name, justify="right")
    for group in _GROUPS:
        for form in _FORMS:
            chosen = [one for one in outcomes if one.group == group and one.form == form]
            inside = [one for one in chosen if one.verdict in ("kept", "OVER")]
            outside = [one for one in chosen if one not in inside]
            if chosen:
                peaks = [one.measured.peak for one in chosen]
                delays = np.concatenate([one.measured.delays for one in chosen]) * 1e3
                table.add_row(
                    group,
                    form,
                    str(len(chosen)),
                    str(len(inside)),
                    str(sum(one.verdict == "OVER" for one in inside)),
                    str(sum(one.measured.peak > OVER for one in outside)),
                    f"{np.median(peaks):.3f}",
                    f"{max(peaks):.4f}",
                    f"{max(one.measured.held for one in chosen) * 1e3:.1f}",
                    f"{np.median(delays):.1f}, max {delays.max():.1f}",
                )
    console.print(table)


def _write(folder: Path, outcomes: list[Outcome]) -> None:
    records = []
    for one in outcomes:
        case = {"set": one.group, "number": one.number, "form": one.form, "verdict": one.verdict}
        measured = ("peak", "travelled", "held", "delay", "stalls")
        records.append(case | {name: getattr(one.measured, name) for name in measured})
    write_csv(folder / "processes.csv", records)


def _status(console: Console, outcomes: list[Outcome]) -> int:
    inside = [one for one in outcomes if one.verdict in ("kept", "OVER")]
    over = [one for one in inside if one.verdict == "OVER"]
    console.print(f"{len(inside)} of {len(outcomes)} cases inside the guarantee, {len(over)} of them over a limit;")
    console.print("in the others a declared time did not hold on this machine, or the processes did not start in time")
    return 1 if over or not inside else 0


if __name__ == "__main__":
    sys.exit(main())
