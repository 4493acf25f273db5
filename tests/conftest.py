"""Fixtures that every test may use: processes, and a real Zenoh router on a free loopback port."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

from tests.support.ports import free_endpoint
from tests.support.processes import Process, Processes

# No property depends on how fast the machine is that checks it.
settings.register_profile("any machine", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("any machine")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Modules with slow tests first: at the end one worker would go on alone for minutes."""
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    items.sort(key=lambda item: item.path not in slow)


StartProcess = Callable[..., Process]


@dataclass(frozen=True)
class Router:
    """A running router process and the endpoint [``tcp/host:port``] that it listens on."""

    process: Process
    endpoint: str


@contextmanager
def _processes(folder: Path) -> Iterator[StartProcess]:
    with Processes(folder) as processes:
        yield processes.start


def _router(start_process: StartProcess) -> Router:
    endpoint = free_endpoint()
    process = start_process("services.router", "--listen", endpoint)
    process.wait_for_output(endpoint)
    return Router(process, endpoint)


@pytest.fixture
def start(tmp_path: Path) -> Iterator[StartProcess]:
    """Starts ``python -m module arguments...``; every process ends with the test, newest first."""
    with _processes(tmp_path) as start_process:
        yield start_process


@pytest.fixture
def router(start: StartProcess) -> Router:
    """A router of the test's own, which it may kill."""
    return _router(start)


@pytest.fixture(scope="module")
def shared_router(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Router]:
    """One router for all tests of a file, which leave it alone."""
    with _processes(tmp_path_factory.mktemp("router")) as start_process:
        yield _router(start_process)


@pytest.fixture
def as_a_process(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[None]:
    """For a test that calls what a process calls: nothing of the user's is used, and what it sets is set back."""
    for name in ("TANDEM_ROBOT", "TANDEM_CONNECT", "TANDEM_CONFIG"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    kept = {number: signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGINT)}
    with np.errstate():
        yield
    for number, handler in kept.items():
        signal.signal(number, handler)
