"""Two versions of the sources against each other, to the last bit, on the same recorded inputs."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

from tests.replay import cases
from tests.replay.player import digests, play
from tests.replay.product import CODE
from tests.replay.recordings import INPUTS
from tests.support.processes import ROOT
from tests.support.revision import worktree

_SOURCES = "sources in "
Digests = dict[tuple[str, str], str]
"""Checksum and number of messages for each case and key."""


def lines(inputs: Path = INPUTS) -> Iterator[str]:
    """Where the replayed sources lie; then case, key, checksum and number of messages, separated by tabs."""
    yield f"{_SOURCES}{CODE}"
    for case in cases.cases(inputs):
        for key, (digest, count) in digests(play(case)).items():
            yield f"{case.name}\t{key}\t{digest}\t{count}"


def compare(revision: str) -> int:
    """Print key by key whether another revision answers alike; the exit status.

    Args:
        revision: of the git repository; it needs a `tests/replay` of its own, which knows where its sources lie.
    """
    with worktree(revision) as folder:
        if not (folder / "tests/replay/__main__.py").exists():
            print(f"{revision} has no tests/replay: nothing to compare with", file=sys.stderr)
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
    command = [sys.executable, "-m", "tests.replay", "digest", "--inputs", str(INPUTS)]
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
