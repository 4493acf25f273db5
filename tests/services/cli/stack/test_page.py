"""The page beside a stack: where it is, or why there is none."""

from __future__ import annotations

import socket
from contextlib import ExitStack

import pytest

from services.cli.stack import page
from services.cli.stack.children import Children
from services.cli.stack.page import Page

ENDPOINT = "tcp/127.0.0.1:1"


def test_nobody_is_told_of_a_page_that_is_not_wanted() -> None:
    with Children() as children:
        assert Page(False, "tiago", ENDPOINT, children).said == ""
        assert not list(children)


def test_without_its_packages_it_is_said_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(page, "lacking", lambda extra: ["rerun-sdk"])
    with Children() as children:
        said = Page(True, "tiago", ENDPOINT, children).said
    assert said == "no page: rerun-sdk not installed: pip install '.[viewer]' in its checkout"


@pytest.mark.parametrize("which", [0, 1])
def test_another_pair_of_ports_is_taken_where_one_of_the_usual_is_not_free(
    which: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    with ExitStack() as open_:
        for usual in range(21000, 30000, 4):
            try:
                open_.enter_context(socket.create_server(("127.0.0.1", usual + which)))
            except OSError:
                continue
            break
        monkeypatch.setattr(page, "PAGE", usual)
        assert page.free_pair() in range(usual + 2, usual + 100, 2)


@pytest.mark.processes
def test_a_viewer_that_ends_is_told() -> None:
    with Children() as children:
        shown = Page(True, "no robot", ENDPOINT, children)
        (child,) = children
        assert child.finish(float("inf")) == 2
        assert shown.said.startswith("no page: the viewer ended with status 2: viewer: --robot")
