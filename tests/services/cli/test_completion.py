"""Completion in bash: words, options and keys, by the script that `tandem --show-completion` prints."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.processes import ROOT

SCRIPT = """
eval "$(tandem --show-completion)"
COMP_WORDS=(tandem "$@")
COMP_CWORD=$#
_tandem_completion tandem
printf '%s\\n' "${COMPREPLY[@]}"
"""


@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        (["resu"], ["resume"]),
        (["hold", "--force"], ["--force-limit"]),
        (["topic", "echo", "wrench/e"], ["wrench/external"]),
        (["task", "re"], ["release", "reset"]),
        (["start", "ba"], ["base"]),
    ],
    ids=" ".join,
)
def test_bash_completes(typed: list[str], offered: list[str], tmp_path: Path) -> None:
    command = tmp_path / "tandem"
    command.write_text(f'#!/bin/sh\nexec {sys.executable} -m services.cli "$@"\n')
    command.chmod(0o755)
    done = subprocess.run(
        ["bash", "-c", SCRIPT, "bash", *typed],
        cwd=ROOT,
        env={"PATH": f"{tmp_path}:/usr/bin:/bin"},
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    assert sorted(done.stdout.split()) == offered, done.stderr
