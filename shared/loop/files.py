"""Where services keep what outlives them, and writing it so that a reader never finds half of it."""

from __future__ import annotations

import os
from pathlib import Path


def default_folder() -> Path:
    """Where state is kept if nothing else is said: the user's state directory."""
    return Path(os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state") / "tandem"


def write_whole(path: Path, text: str) -> None:
    """Replace a file in one step; its folder is made if need be.

    Raises:
        OSError: if that is not possible; the file is as it was then.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    fresh = path.with_name(f"{path.name}.{os.getpid()}")
    fresh.write_text(text, encoding="utf-8")
    fresh.replace(path)
