"""Renders a recorded run to a short film: ``python -m services.sim.film.film FILM.npz OUT.mp4``.

The recording is not the experiment's own, but what ``services.experiment film FOLDER`` takes from it. What it has to
hold depends on its ``scene``, "load" or "carry": see ``load_film.py`` and ``carry_recording.py``. A carry gets
``strip.png`` beside the film as well.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import imageio.v2 as imageio
import numpy as np

from services.sim.camera.canvas import Picture
from services.sim.film import carry_film, load_film
from services.sim.film.carry_recording import CarryRun
from services.sim.film.load_film import LoadRun
from shared.loop.config import Misconfigured, OneLineParser, complain

STRIP = "strip.png"


def load(path: Path) -> LoadRun | CarryRun:
    """Read a recording.

    Raises:
        Misconfigured: if the file is missing or does not hold what a film needs; one line.
    """
    try:
        with np.load(path, allow_pickle=False) as archive:
            data = {name: archive[name] for name in archive.files}
        return CarryRun(data) if str(data["scene"]) == "carry" else LoadRun.of(data)
    except Misconfigured as problem:
        raise Misconfigured(f"{path}: {problem}") from None
    except OSError as problem:
        raise Misconfigured(f"{path}: {problem.strerror or problem}") from None
    except (KeyError, ValueError) as problem:
        raise Misconfigured(f"{path}: no recording of a run ({problem})") from None


def write(pictures: Iterable[Picture], path: Path, rate: float) -> int:
    """Write a film (MP4, H.264) of ``rate`` pictures a second; returns how many there are."""
    count = 0
    writer: Any = imageio.get_writer(path, fps=rate, codec="libx264", quality=7, macro_block_size=4)
    with writer as film:
        for picture in pictures:
            film.append_data(picture)
            count += 1
    return count


def render(source: Path, out: Path, rate: float = 15.0, speed: float = 3.0) -> int:
    """Render a recording to a film, and that of a carry to stills beside it as well; returns the number of pictures.

    Args:
        source: NPZ file of the recording.
        out: MP4 file to write; its folder exists.
        rate: pictures per second.
        speed: how many times faster than it happened.

    Raises:
        Misconfigured: if ``source`` holds no recording, or ``out`` has no folder; one line.
    """
    run = load(source)
    folder = out.parent
    if not folder.is_dir():
        raise Misconfigured(f"{folder}: no such folder; make it first")
    if isinstance(run, CarryRun):
        imageio.imwrite(folder / STRIP, carry_film.strip(run))
        return write(carry_film.frames(run, rate, speed), out, rate)
    return write(load_film.frames(run, rate, speed), out, rate)


def main(arguments: list[str] | None = None) -> int:
    """Command line; returns the exit status."""
    parser = OneLineParser(prog="python -m services.sim.film.film", description="render a recorded run")
    parser.add_argument("recording", type=Path, help="NPZ file of the run")
    parser.add_argument("film", type=Path, help="MP4 file to write")
    parser.add_argument("--rate", type=_positive, default=15.0, help="pictures per second")
    parser.add_argument("--speed", type=_positive, default=3.0, help="how many times faster than it happened")
    try:
        options = parser.parse_args(arguments)
        count = render(options.recording, options.film, options.rate, options.speed)
    except Misconfigured as problem:
        return complain("film", problem)
    print(f"{options.film}: {count} pictures, {count / options.rate:.0f} s")
    return 0


def _positive(text: str) -> float:
    value = float(text)
    if not 0.0 < value <= 1000.0:
        raise argparse.ArgumentTypeError(f"{text} is not in the range above 0 to 1000")
    return value


if __name__ == "__main__":
    sys.exit(main())
