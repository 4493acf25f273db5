"""Two versions of the sources against each other, to the last bit, on the same recordings."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import shared
from services.experiment.replay.recorded import read
from services.experiment.replay.replay import replay
from shared.wire.log import NoRecording
from tests.replay.record import RECORDINGS
from tests.support.processes import ROOT
from tests.support.revision import worktree

CODE = Path(next(iter(shared.__path__))).resolve().parent
"""Where the replayed sources lie."""
SERVICES = ("wrench", "controller", "base", "task")
_SOURCES = "sources in "
Digests = dict[tuple[str, str], str]
"""Checksum and number of answers for each recording, and service and key."""


def lines(recordings: Path = RECORDINGS) -> Iterator[str]:
    """Where the replayed sources lie; then recording, service and key, checksum and number of answers, with tabs."""
    yield f"{_SOURCES}{CODE}"
    for path in sorted(recordings.iterdir()):
        for service in SERVICES:
            try:
                found = read([path], service)
            except NoRecording:
                continue
            for number, life in enumerate(found.lives, 1):
                for key, answers in sorted(replay(found, life, {}).answers.items()):
                    digest = hashlib.sha256(b"".join(answers[stamp].payload for stamp in sorted(answers)))
                    yield f"{path.stem}\t{service} {number} {key}\t{digest.hexdigest()}\t{len(answers)}"


def compare(revision: str) -> int:
    """Print key by key whether another revision answers alike; the exit status.

    Args:
        revision: of the git repository; it needs a `tests/replay` of its own that replays recordings.
    """
    with worktree(revision) as folder:
        if not (folder / "tests/replay/recordings").exists():
            print(f"{revision} has no tests/replay/recordings: nothing to compare with", file=sys.stderr)
            return 2
        # Both at once, each in a process of its own.
        theirs, ours = _start(folder), _start(ROOT)
        before, now = _finished(theirs, folder), _finished(ours, ROOT)
    different = 0
    for name in sorted({*before, *now}):
        alike = before.get(name) == now.get(name)
        different += not alike
        found = f"{before.get(name, 'nothing')[:12]} before, {now.get(name, 'nothing')[:12]} now"
        print(f"{'equal    ' if alike else 'DIFFERENT'} {name[0]}: {name[1]}{'' if alike else f' ({found})'}")
    total = len({*before, *now})
    print(f"{total - different} of {total} equal to the last bit, {revision} against the working tree")
    return 1 if different or not total else 0


def _start(folder: Path) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "tests.replay", "digest", "--recordings", str(RECORDINGS)]
    return subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True)


def _finished(process: subprocess.Popen[str], folder: Path) -> Digests:
    output, _ = process.communicate()
    if process.returncode:
        raise SystemExit(f"the replay in {folder} failed with exit status {process.returncode}")
    first, *rest = output.splitlines()
    # An installed copy of the sources, imported by mistake, would be compared with itself.
    if Path(first.removeprefix(_SOURCES)) != folder.resolve():
        raise SystemExit(f"the replay in {folder} has imported the {first}")
    rows = [line.split("\t") for line in rest]
    return {(case, key): f"{digest} {count}" for case, key, digest, count in rows}
