"""A process that lives through all tests of its promises, and one that a test may do away with."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.conftest import StartProcess, _processes, _router
from tests.promises.subjects import SUBJECTS, Subject
from tests.promises.surroundings import Surroundings
from tests.support.processes import Process

Launch = Callable[[Subject, str], Process]


@pytest.fixture
def launch(start: StartProcess, tmp_path: Path) -> Launch:
    """Starts a subject on the router at an endpoint."""
    return lambda subject, endpoint: _launch(start, subject, endpoint, tmp_path)


def _launch(start: StartProcess, subject: Subject, endpoint: str, folder: Path) -> Process:
    environment = {"XDG_STATE_HOME": str(folder), **subject.behind(start, endpoint)}
    return start(subject.process.module, *subject.arguments(endpoint, str(folder)), environment=environment)


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Those that a subject lives through come one after the other: it is started once for all of them."""
    here = Path(__file__).parent
    # The items are those of all folders, where a fixture may have the same name.
    own = [here in item.path.parents and "stage" in getattr(item, "fixturenames", ()) for item in items]
    places = [place for place, is_own in enumerate(own) if is_own]
    lived_through = (items[place] for place in places)
    together = sorted(lived_through, key=lambda item: SUBJECTS.index(item.callspec.params["subject"]))
    for place, item in zip(places, together, strict=True):
        items[place] = item


class Stage:
    """One subject in its surroundings, until another one is asked for."""

    def __init__(self, start: StartProcess, folder: Path) -> None:
        self._start, self._folder = start, folder
        self._router = _router(start)
        self._around: Surroundings | None = None
        self._process: Process | None = None

    @property
    def endpoint(self) -> str:
        """Of the router that all of them are connected to."""
        return self._router.endpoint

    def shows(self, subject: Subject) -> tuple[Surroundings, Process]:
        """The subject's surroundings and process, started if it is another one than before."""
        if self._around is None or self._around.subject is not subject:
            self.clear()
            self._around = Surroundings(self._router.endpoint, subject).__enter__()
            self._process = _launch(self._start, subject, self._router.endpoint, self._folder)
        assert self._process is not None
        return self._around, self._process

    def clear(self) -> None:
        """End them."""
        if self._around is not None and self._process is not None:
            self._process.stop()
            self._around.__exit__()


@pytest.fixture(scope="package")
def stage(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Stage]:
    folder = tmp_path_factory.mktemp("stage")
    with _processes(folder) as start:
        stage = Stage(start, folder)
        yield stage
        stage.clear()


@pytest.fixture
def around(stage: Stage, subject: Subject) -> Iterator[Surroundings]:
    """The surroundings of a subject that works, before the test and after it: it has to live through everything."""
    around, process = stage.shows(subject)
    around.begun()
    yield around
    around.spoil.clear()
    around.begun()
    around.unharmed()
    assert process.running, process.output
    assert "Traceback" not in process.output, process.output
