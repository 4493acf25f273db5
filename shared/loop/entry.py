"""The way into and out of a process; imports nothing heavy, so that a signal finds it ready from the start."""

from __future__ import annotations

import importlib
import os
import signal
import sys
from typing import NoReturn


def enter(module: str) -> NoReturn:
    """Run ``main()`` of a module and end the process with the exit status that it returns.

    SIGTERM and SIGINT end the process with status 0 even while the module is still being imported.
    """
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda _number, _frame: os._exit(0))
    end(importlib.import_module(module).main())


def end(status: int) -> NoReturn:
    """End this process now, with everything printed.

    A thread of Zenoh that waits for the interpreter while it is taken down aborts the process, closed session or not;
    so it is not taken down.
    """
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)
