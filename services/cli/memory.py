"""What is remembered of the stacks that run: a small file of each, in the user's part of the temporary directory."""

from __future__ import annotations

import json
import os
import tempfile
from pathlib import Path
from typing import Any


def keep(robot: str, endpoint: str, options: dict[str, Any]) -> None:
    """Writes down that this command runs a stack of a robot at an endpoint, and its options."""
    path = _path(robot, endpoint)
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    about = {"robot": robot, "endpoint": endpoint, "pid": os.getpid()}
    path.write_text(json.dumps({**about, **options}), encoding="utf-8")


def forget(robot: str, endpoint: str) -> None:
    """Removes what `keep` wrote."""
    _path(robot, endpoint).unlink(missing_ok=True)


def kept(robot: str, endpoint: str) -> dict[str, Any] | None:
    """What is written down of a stack; None if there is nothing."""
    return _read(_path(robot, endpoint))


def running() -> list[tuple[str, str]]:
    """Robot and endpoint of every stack whose command still runs."""
    found = (_read(path) for path in sorted(_folder().glob("*.json")))
    return [(one["robot"], one["endpoint"]) for one in found if one and _runs(one.get("pid", 0))]


def left_behind() -> list[Path]:
    """The files of commands that have ended without removing them."""
    found = ((path, _read(path)) for path in sorted(_folder().glob("*.json")))
    return [path for path, one in found if one is None or not _runs(one.get("pid", 0))]


def _folder() -> Path:
    return Path(tempfile.gettempdir()) / f"tandem-{os.getuid()}"


def _path(robot: str, endpoint: str) -> Path:
    place = "".join(letter if letter.isalnum() else "-" for letter in f"{robot} {endpoint}")
    return _folder() / f"{place}.json"


def _read(path: Path) -> dict[str, Any] | None:
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, json.JSONDecodeError):
        return None


def _runs(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except OSError:
        return False
    return pid > 0
