"""A film of a recorded run, rendered by the simulator in a process of its own: services never import each other."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

from services.experiment.play.recording import RECORDING, Recording

FILM = "scene.mp4"
STRIP = "strip.png"
"""Stills that the renderer puts beside the film of a carry."""
PATIENCE = 300.0  # [s]


def render(folder: Path, film_data: Callable[[Recording, Path], None]) -> str:
    """Renders the run in `folder` to FILM beside its recording; returns why there is none, empty if there is.

    Args:
        folder: of the run.
        film_data: writes what the renderer reads of a recording.

    Raises:
        FileNotFoundError: there is no recording.
        KeyError: the recording lacks what the film shows.
    """
    source, film = folder / "film.npz", folder / FILM
    film_data(Recording.load(folder / RECORDING), source)
    try:
        done = subprocess.run(
            [sys.executable, "-m", "services.sim.film.film", str(source), str(film)],
            capture_output=True,
            text=True,
            timeout=PATIENCE,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return f"rendering took over {PATIENCE:.0f} s"
    finally:
        source.unlink(missing_ok=True)
    if done.returncode == 0 and film.exists():
        return ""
    said = (done.stderr.strip() or done.stdout.strip() or "it said nothing").splitlines()[-1]
    return f"services.sim.film.film ended with status {done.returncode}: {said}"
