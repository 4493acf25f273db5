"""A command that ends when whoever started it is gone, whatever way that ended."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

_DIE_WITH_PARENT = """
import ctypes, os, signal, sys
if sys.platform == "linux":
    ctypes.CDLL(None).prctl(1, signal.SIGTERM)
if os.getppid() == int(sys.argv[1]):
    os.execv(sys.argv[2], sys.argv[2:])
"""
"""Runs in the child before the command: PR_SET_PDEATHSIG has the kernel send it SIGTERM when the parent is gone, even
by SIGKILL. Not a preexec_fn, which may deadlock in a process that has threads."""


def tethered(command: Sequence[str]) -> list[str]:
    """A command line, of which the program is a path, as one that does not outlive this process.

    Start it from the main thread: the kernel's notice of a parent's death is about the thread that forked.
    """
    return [sys.executable, "-S", "-c", _DIE_WITH_PARENT, str(os.getpid()), *command]
