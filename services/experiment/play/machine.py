"""On what a run was played: the version of the sources, and the machine."""

from __future__ import annotations

import os
import platform
import subprocess
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

_ROOT = Path(__file__).resolve().parents[3]


def machine() -> dict[str, Any]:
    """JSON types: the commit, cores, load average of the last minute, kind of machine, Python."""
    return {
        "commit": commit(),
        "cores": os.cpu_count(),
        "load_1min": round(os.getloadavg()[0], 2),
        "machine": f"{platform.machine()}, {platform.system()} {platform.release()}",
        "python": platform.python_version(),
    }


def commit(root: Path = _ROOT) -> str:
    """The commit of the sources in a folder, and whether they differ from it; of an installed package its version."""
    if (root / ".git").exists():
        try:
            head = _git(root, "rev-parse", "--short=12", "HEAD")
            return f"{head}, changed since" if _git(root, "status", "--porcelain", "--untracked-files=no") else head
        except (OSError, subprocess.CalledProcessError):
            pass  # without git, or a folder of somebody else
    try:
        return f"version {version('tandem')}"
    except PackageNotFoundError:
        return ""


def _git(root: Path, *command: str) -> str:
    done = subprocess.run(["git", "-C", str(root), *command], capture_output=True, text=True, check=True)
    return done.stdout.strip()
