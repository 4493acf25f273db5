"""What a recording says of the sources and the machine that it was made with."""

from __future__ import annotations

import json
import subprocess
from importlib.metadata import version
from pathlib import Path

from services.experiment.play.machine import commit, machine


def git(folder: Path, *command: str) -> str:
    identity = ("-c", "user.name=test", "-c", "user.email=test@example.org")
    done = subprocess.run(["git", *identity, *command], cwd=folder, capture_output=True, text=True, check=True)
    return done.stdout.strip()


def test_a_checkout_is_told_by_its_commit_and_whether_it_was_changed(tmp_path: Path) -> None:
    git(tmp_path, "init", "-q")
    (tmp_path / "file").write_text("one")
    git(tmp_path, "add", "file")
    git(tmp_path, "commit", "-q", "-m", "one")
    head = git(tmp_path, "rev-parse", "HEAD")
    assert commit(tmp_path) == head[:12]
    (tmp_path / "file").write_text("two")
    assert commit(tmp_path) == f"{head[:12]}, changed since"


def test_what_is_installed_is_told_by_its_version(tmp_path: Path) -> None:
    assert commit(tmp_path) == f"version {version('tandem')}"
    (tmp_path / ".git").touch()
    assert commit(tmp_path) == f"version {version('tandem')}", "a folder that git does not know"


def test_the_machine_is_told_in_plain_types() -> None:
    told = machine()
    assert json.loads(json.dumps(told)) == told
    assert told["cores"] > 0 and told["load_1min"] >= 0.0
