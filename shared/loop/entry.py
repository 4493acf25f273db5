"""The way into and out of a process; imports nothing heavy, so that a signal finds it ready from the start."""

from __future__ import annotations

import importlib
import os
import signal
import sys
from typing import NoReturn


def enter(module: str) -> NoReturn:
    """Run ``main()`` of a module and end the process with the exit status that it returns.

    SIGTERM and SIGINT end the process with status 0 even while the module is still being imported. What the service
    needs and is not installed ends it with status 2 and one line.
    """
    end_at_once()
    try:
        status = importlib.import_module(module).main()
    except ModuleNotFoundError as problem:
        service = module.split(".")[1]
        print(f"{service}: {missing(service, problem)}", file=sys.stderr)
        status = 2
    end(status)


def end_at_once() -> None:
    """Have SIGTERM and SIGINT end the process with status 0 from now on, whatever it is doing."""
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda _number, _frame: os._exit(0))


def missing(service: str, problem: ModuleNotFoundError) -> str:
    """Which package a process lacks, and how to get it; raises the problem again where it is of this project itself."""
    from shared.processes import process_named

    package = (problem.name or "").partition(".")[0]
    if package in ("", "services", "shared"):
        raise problem
    extra = process_named(service).extra
    remedy = f"pip install '.[{extra}]' in its checkout" if extra else "install tandem with its dependencies"
    if package == "pybullet" and sys.version_info >= (3, 12):
        remedy = f"it has no wheels above Python 3.11, and this is {sys.version_info[0]}.{sys.version_info[1]}"
    return f"needs {package}, which is not installed: {remedy}"


def end(status: int) -> NoReturn:
    """End this process now, with everything printed.

    A thread of Zenoh that waits for the interpreter while it is taken down aborts the process, closed session or not;
    so it is not taken down.
    """
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)
