"""`tandem record` and `tandem export`: what is said on the bus, on the disk and as tables."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from services.cli.common import DEFAULT_ENDPOINT, DEFAULT_ROBOT, Connect, Robot, check_place, refuse, working
from services.cli.extras import need
from services.experiment.play.recording import END, RUN, Recording
from services.recorder.topics import everything
from shared.clock import seconds
from shared.processes import RECORDER
from shared.wire.log import ABOUT, Heard, Log, NoRecording, recordings


def record(
    out: Annotated[Path | None, typer.Option(help="Folder of the recording; default runs/record-<date>.")] = None,
    most: Annotated[int, typer.Option(metavar="MB", help="On the disk; the oldest goes first.")] = 2000,
    camera: Annotated[bool, typer.Option(help="Pictures too; they are taken only if somebody wants them.")] = True,
    robot: Robot = DEFAULT_ROBOT,
    connect: Connect = DEFAULT_ENDPOINT,
) -> None:
    """Write all that is said of a robot to the disk (MCAP), until Ctrl-C."""
    check_place("--out", out or Path("runs"), most)
    command = [sys.executable, "-m", RECORDER.module, "--robot", robot, "--connect", connect]
    command += ["--most", str(most), *(["--out", str(out)] if out else []), *([] if camera else ["--no-camera"])]
    # The recorder itself from here on: signals and exit status are its own.
    os.execv(command[0], command)


def export(
    recording: Annotated[Path, typer.Argument(help="A recording, or a folder of them; numbered files are one.")],
    csv: Annotated[Path | None, typer.Option(help="Folder for a CSV file per topic.")] = None,
    foxglove: Annotated[Path | None, typer.Option(help="File (.mcap) that Foxglove and rerun show.")] = None,
) -> None:
    """Turn recordings into tables, times in seconds from the beginning, or into what other programs show."""
    if csv is None and foxglove is None:
        refuse(f"export {recording}: say what to make of it: --csv FOLDER, --foxglove FILE")
    if csv is not None:
        check_place("--csv", csv, 0.0)
    if foxglove is not None:
        check_place("--foxglove", foxglove.absolute().parent, 0.0)
    try:
        found = recordings(recording)
        with working(path for paths in found for path in paths):
            if foxglove is not None:
                _for_foxglove(recording, found, foxglove)
            if csv is not None:
                for paths in found:
                    _tables(recording, paths, csv, len(found) > 1)
    except NoRecording as problem:
        refuse(str(problem), 1)
    except OSError as problem:
        # What is read is opened by its name; what cannot be written on has none.
        refuse(f"{problem.filename or csv or foxglove}: {problem.strerror}", 1)


def _tables(place: Path, paths: list[Path], csv: Path, several: bool) -> None:
    about: dict[str, dict[str, Any]] = {}
    heard: list[Heard] = []
    # Pictures are in no table, and would fill the memory.
    keys = {topic.key for topic in everything(camera=False)}
    for path in paths:
        log = Log(path, keys)
        heard += log
        about |= log.about
    first = seconds(heard[0].arrival_ns) if heard else 0.0
    said = {**about[ABOUT], **about.get(RUN, {})}
    series = Recording.of(said, heard, about.get(END, {"start": first, "events": []}))
    folder = csv / paths[0].relative_to(place).with_suffix("") if several else csv
    typer.echo(f"{paths[0]}: {len(series.write_csv(folder))} tables in {folder}")


def _for_foxglove(place: Path, found: list[list[Path]], out: Path) -> None:
    if len(found) > 1:
        refuse(f"{place}: {len(found)} recordings, name one: {', '.join(str(paths[0]) for paths in found)}")
    if out.exists():
        refuse(f"--foxglove {out}: there already")
    need({RECORDER.name})
    # Only here: tables need none of Foxglove's types.
    from services.recorder.export import export as written

    out.parent.mkdir(parents=True, exist_ok=True)
    done = written(found[0], out)
    typer.echo(f"{out}: {done.messages:,} messages as JSON, {done.shown:,} of Foxglove's types")
    for key, count in done.rejected.items():
        typer.echo(f"{key}: {count:,} payloads are no messages of the contract, and left out", err=True)
