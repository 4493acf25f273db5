"""`tandem replay`: recorded inputs, given to one service again."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console

from services.cli.common import AsJson, check_place, refuse, three, working
from services.cli.extras import need
from services.cli.listing import Listing, show_json
from services.cli.param import read as value_read
from services.cli.param import shown
from services.experiment.replay import equality, outcome, recorded
from services.experiment.replay.recorded import Life, Recorded
from services.experiment.replay.replay import Replayed, complete, replay
from services.experiment.replay.subjects import SUBJECTS
from shared.loop.config import assignment
from shared.parameters import Refused
from shared.schema.fields import InvalidField
from shared.wire.log import ABOUT, Heard, Log, NoRecording, recordings, write_log


def replay_(
    recording: Annotated[Path, typer.Argument(help="A recording, or the folder of one: numbered files are one.")],
    into: Annotated[str, typer.Option(help=f"Service that takes it: {', '.join(SUBJECTS)}.")],
    settings: Annotated[
        list[str], typer.Option("--set", help="NAME=VALUE in TOML, in place of what it was; repeatable.")
    ] = [],  # noqa: B006 - typer copies it
    force_limit: Annotated[str | None, typer.Option(help="Force limits [N] of each target: one, or x,y,z.")] = None,
    torque_limit: Annotated[str | None, typer.Option(help="Torque limits [Nm] of each target: one, or x,y,z.")] = None,
    out: Annotated[Path | None, typer.Option(help="Write what is answered as a recording, to this file.")] = None,
    as_json: AsJson = False,
) -> None:
    """Give a service what it was given, and compare what it answers; with a change, say what would have been different.

    Exit status 1 if nothing was changed and an answer differs.
    """
    if into not in SUBJECTS:
        refuse(f"--into {into!r}: choose from {', '.join(SUBJECTS)}")
    need({into})
    changes = _changes(settings)
    limits = {
        name: np.array(three(f"--{name.replace('_', '-')}", text))
        for name, text in (("force_limit", force_limit), ("torque_limit", torque_limit))
        if text is not None
    }
    if limits and into != "controller":
        refuse(f"limits are the controller's: --into controller, not {into}")
    try:
        paths = _the_one(recording)
        if out is not None:
            if out.exists():
                refuse(f"--out {out}: there already")
            check_place("--out", out.absolute().parent, sum(path.stat().st_size for path in paths) / 1e6)
        with working(paths):
            read, again = complete(paths, into)
            edit = outcome.limited(limits)
            played = [(life, replay(read, life, changes, edit)) for life in read.lives]
            if out is not None:
                _write(out, paths, read, played, {"service": into, "set": {**changes, **_plain(limits)}})
    except NoRecording as problem:
        refuse(str(problem), 1)
    except (InvalidField, Refused) as problem:
        refuse(f"{into}: {problem}")
    except OSError as problem:
        refuse(f"{problem.filename or out or recording}: {problem.strerror}", 1)
    if out is not None:
        typer.echo(f"{out} has what is answered now; to see both: tandem view {paths[0]} --beside {out}", err=True)
    if changes or limits:
        _tell_outcome(into, played, {**changes, **_plain(limits)}, as_json)
        return
    found = [equality.equality(*one) for one in played]
    if as_json:
        show_json({"service": into, "said_again": again, "starts": [dataclasses.asdict(one) for one in found]})
    else:
        for number, one in enumerate(found, 1):
            lines = equality.told(into, one)
            lines[0] += f" (start {number} of {len(found)})" if len(found) > 1 else ""
            typer.echo("\n".join(lines))
        if again:
            typer.echo(f"{again:,} messages that the recording did not hear were said again by replaying who said them")
    if any(one.equal < one.compared for one in found):
        raise typer.Exit(1)


def _changes(settings: list[str]) -> dict[str, Any]:
    changes = {}
    for setting in settings:
        try:
            name, text = assignment(setting)
        except ValueError:
            refuse(f"--set {setting!r}: wanted NAME=VALUE, such as max_linear=0.1")
        changes[name] = value_read(text)
    return changes


def _plain(limits: dict[str, np.ndarray]) -> dict[str, list[float]]:
    return {name: limit.tolist() for name, limit in limits.items()}


def _the_one(place: Path) -> list[Path]:
    """The files of the one recording at a place."""
    found = recordings(place)
    if len(found) > 1:
        refuse(f"{place}: {len(found)} recordings, name one: {', '.join(str(paths[0]) for paths in found)}")
    return found[0]


def _tell_outcome(service: str, played: list[tuple[Life, Replayed]], changes: dict[str, Any], as_json: bool) -> None:
    starts = [
        (outcome.first_difference(life.answers, one.answers), outcome.figures(life.answers, one.answers))
        for life, one in played
    ]
    if as_json:
        plain = [
            {"first": first and dataclasses.asdict(first), "figures": [dataclasses.asdict(one) for one in figures]}
            for first, figures in starts
        ]
        show_json({"service": service, "changed": changes, "note": outcome.OPEN_LOOP, "starts": plain})
        return
    typer.echo(f"{service} with {', '.join(f'{name} = {shown(value)}' for name, value in changes.items())}")
    typer.echo(outcome.OPEN_LOOP)
    for first, figures in starts:
        if first is None:
            typer.echo("nothing would have been different")
            continue
        typer.echo(
            f"first difference: {first.key} at {first.time:.4f} s: {first.place} "
            f"was {shown(first.recorded)}, would be {shown(first.replayed)}"
        )
        rows = Listing("what", "recorded>", "with the change>", "unit")
        for one in figures:
            if one.recorded == one.replayed == 0.0:
                continue
            rows.add(one.name, f"{one.recorded:.4g}", f"{one.replayed:.4g}", one.unit)
        Console().print(rows)


def _write(
    out: Path, paths: list[Path], read: Recorded, played: list[tuple[Life, Replayed]], about: dict[str, Any]
) -> None:
    """The recording with what is answered now in place of what was."""
    sessions = {life.session for life, _ in played}
    said: list[Heard] = []
    kept: list[Heard] = []
    own = {topic.key for topic in recorded.outputs(read.service)}
    for path in paths:
        kept += (one for one in Log(path) if one.key not in own or not recorded.said_by(one, sessions))
    for _, one in played:
        said += (
            Heard(key, stamp + read.ahead, answer.payload)
            for key, answers in one.answers.items()
            for stamp, answer in answers.items()
        )
    heard = sorted([*kept, *said], key=lambda one: one.arrival_ns)
    notes = {name: content for name, content in read.about.items() if name != ABOUT}
    out.parent.mkdir(parents=True, exist_ok=True)
    write_log(out, {**read.about[ABOUT], "replayed": about}, heard, **notes)
