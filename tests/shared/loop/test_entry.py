"""The way into a process: what is not installed is named in one line, with the remedy."""

from __future__ import annotations

import subprocess
import sys

import pytest

from shared.processes import PROCESSES
from tests.support.processes import ROOT


@pytest.mark.parametrize(
    ("service", "package", "remedy"),
    [
        (
            "sim",
            "pybullet",
            "pip install '.[sim]' in its checkout" if sys.version_info < (3, 12) else "no wheels above Python 3.11",
        ),
        ("controller", "piqp", "pip install '.[controller]' in its checkout"),
        ("task", "cv2", "pip install '.[task]' in its checkout"),
    ],
)
def test_what_is_not_installed_is_one_line(service: str, package: str, remedy: str) -> None:
    assert service in {process.name for process in PROCESSES}
    code = (
        f"import sys; sys.modules[{package!r}] = None; sys.argv[1:] = ['--connect', 'tcp/127.0.0.1:1']\n"
        f"from shared.loop.entry import enter; enter('services.{service}.main')"
    )
    ended = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=60)
    assert ended.returncode == 2
    (line,) = ended.stderr.splitlines()
    assert line.startswith(f"{service}: needs {package}, which is not installed: ")
    assert remedy in line
