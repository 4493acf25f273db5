"""Renders a recorded run to a short film, as a function for whoever has the recording."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import imageio.v2 as imageio

from services.sim.camera.canvas import Picture
from services.sim.film import carry_film, load_film
from services.sim.film.carry_recording import CarryRun
from services.sim.film.load_film import LoadRun
from shared.loop.config import Misconfigured

FILM, STRIP = "scene.mp4", "strip.png"
"""Names of the film, and of the stills that a carry gets beside it."""


def render(data: Mapping[str, Any], folder: Path, rate: float = 15.0, speed: float = 3.0) -> int:
    """Write the film of a run, and of a carry the strip of stills, to a folder.

    Args:
        data: the recording; what it has to hold depends on its ``scene``, "load" or "carry": see ``load_film.py`` and
            ``carry_recording.py``.
        folder: where film and strip go.
        rate: pictures per second of film.
        speed: how many times faster than it happened.

    Returns:
        The number of pictures.

    Raises:
        Misconfigured: the recording does not hold what a film needs; one line.
    """
    try:
        run = CarryRun(data) if data["scene"] == "carry" else LoadRun.of(data)
    except KeyError as problem:
        raise Misconfigured(f"no recording of a run: {problem} is missing") from None
    if isinstance(run, CarryRun):
        imageio.imwrite(folder / STRIP, carry_film.strip(run))
        return _write(carry_film.frames(run, rate, speed), folder / FILM, rate)
    return _write(load_film.frames(run, rate, speed), folder / FILM, rate)


def _write(pictures: Iterable[Picture], path: Path, rate: float) -> int:
    """Write a film (MP4, H.264) of ``rate`` pictures a second; returns how many there are."""
    count = 0
    writer: Any = imageio.get_writer(path, fps=rate, codec="libx264", quality=7, macro_block_size=4)
    with writer as film:
        for picture in pictures:
            film.append_data(picture)
            count += 1
    return count
