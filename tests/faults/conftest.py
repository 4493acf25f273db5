"""The chain that all tests of a file share: the same two processes have to live through everything."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.conftest import Router, StartProcess, _processes
from tests.faults.chain import Chain


@pytest.fixture(scope="module")
def chain(shared_router: Router, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Chain]:
    folder = tmp_path_factory.mktemp("chain")
    with _processes(folder) as start_process, Chain(shared_router, start_process, folder) as chain:
        yield chain


@pytest.fixture
def own_chain(router: Router, start: StartProcess, tmp_path: Path) -> Iterator[Chain]:
    """A chain with a router that the test may kill."""
    with Chain(router, start, tmp_path) as chain:
        yield chain
