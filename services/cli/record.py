"""`tandem record` and `tandem export`: what is said on the bus, on the disk and as tables."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Annotated

import typer

from services.cli.common import DEFAULT_ENDPOINT, DEFAULT_ROBOT, Connect, Robot, refuse
from services.experiment.play.recording import END, RUN, Recording
from shared.clock import seconds
from shared.processes import process_named
from shared.wire.log import ABOUT, SUFFIX, Log, NoRecording


def record(
    out: Annotated[Path | None, typer.Option(help="Folder of the recording; default runs/record-<date>.")] = None,
    most: Annotated[int, typer.Option(metavar="MB", help="On the disk; the oldest goes first.")] = 2000,
    camera: Annotated[bool, typer.Option(help="Pictures too; they are taken only if somebody wants them.")] = True,
    robot: Robot = DEFAULT_ROBOT,
    connect: Connect = DEFAULT_ENDPOINT,
) -> None:
    """Write all that is said of a robot to the disk (MCAP), until Ctrl-C."""
    command = [sys.executable, "-m", process_named("recorder").module, "--robot", robot, "--connect", connect]
    command += ["--most", str(most), *(["--out", str(out)] if out else []), *([] if camera else ["--no-camera"])]
    # The recorder itself from here on: signals and exit status are its own.
    os.execv(command[0], command)


def export(
    recording: Annotated[Path, typer.Argument(help="A recording, or a folder of them.")],
    csv: Annotated[Path | None, typer.Option(help="Folder for a CSV file per topic.")] = None,
) -> None:
    """Turn recordings into tables, times in seconds from the beginning."""
    files = sorted(recording.glob(f"**/*{SUFFIX}")) if recording.is_dir() else [recording]
    if not files:
        refuse(f"{recording}: no recording (*{SUFFIX}) in it")
    if csv is None:
        refuse(f"export {recording}: say what to make of it: --csv FOLDER")
    for file in files:
        try:
            log = Log(file)
            heard = list(log)
            about = {**log.about[ABOUT], **log.about.get(RUN, {})}
            first = seconds(heard[0].arrival_ns) if heard else 0.0
            series = Recording.of(about, heard, log.about.get(END, {"start": first, "events": []}))
            folder = csv / file.relative_to(recording).with_suffix("") if len(files) > 1 else csv
            written = series.write_csv(folder)
        except NoRecording as problem:
            refuse(str(problem), 1)
        except OSError as problem:
            refuse(f"{problem.filename or file}: {problem.strerror}", 1)
        typer.echo(f"{file}: {len(written)} tables in {folder}")
