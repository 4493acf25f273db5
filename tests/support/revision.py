"""Another revision of the sources in a folder of its own, to be run beside this one."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.support.processes import ROOT


@contextmanager
def worktree(revision: str) -> Iterator[Path]:
    """A folder with the sources of a revision of git, such as HEAD; removed in the end.

    Raises:
        SystemExit: 2 if git refuses, after its own words.
    """
    with tempfile.TemporaryDirectory() as parent:
        folder = Path(parent).resolve() / "before"
        _git("worktree", "add", "--quiet", "--detach", str(folder), revision)
        try:
            yield folder
        finally:
            _git("worktree", "remove", "--force", str(folder))


def _git(*arguments: str) -> None:
    if subprocess.run(["git", *arguments], cwd=ROOT).returncode:
        raise SystemExit(2)
