"""What shows the drawing: the desktop's browser where there is one, rerun's own viewer where it is asked for."""

from __future__ import annotations

import sys
import threading
import webbrowser
from pathlib import Path

import pytest

from services.viewer.looking import looked_at
from services.viewer.page import rerun_files
from shared.loop.config import Misconfigured
from tests.support.wait import eventually

URL, SOURCE = "http://127.0.0.1:9090/", "rerun+http://127.0.0.1:9091/proxy"


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    urls: list[str] = []
    monkeypatch.setattr(webbrowser, "open", urls.append)
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(sys, "platform", "linux")
    return urls


@pytest.mark.parametrize("name", ["DISPLAY", "WAYLAND_DISPLAY"])
def test_the_page_opens_on_a_desktop(opened: list[str], monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    monkeypatch.setenv(name, ":0")
    with looked_at(URL, SOURCE, browser=True, native=False) as seen:
        assert seen()
        eventually(lambda: opened == [URL])


def test_without_a_desktop_or_unasked_nothing_opens(opened: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    with looked_at(URL, SOURCE, browser=True, native=False) as seen:
        assert seen()
    monkeypatch.setenv("DISPLAY", ":0")
    with looked_at(URL, SOURCE, browser=False, native=False):
        assert not [thread for thread in threading.enumerate() if thread.name == "browser"]
    assert opened == []


def script(folder: Path, text: str) -> Path:
    """A program that stands for rerun's own viewer."""
    path = folder / "rerun"
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)
    return path


def test_the_viewer_of_rerun_s_is_given_the_source_on_loopback_and_reports_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    told = tmp_path / "told"
    program = script(tmp_path, f'echo "$CI $@" > {told}.new; mv {told}.new {told}; exec sleep 600')
    monkeypatch.setattr(rerun_files, "program", lambda: program)
    with looked_at(URL, SOURCE, browser=False, native=True) as seen:
        eventually(told.exists)
        assert seen()
    assert told.read_text() == f"1 {SOURCE} --bind 127.0.0.1 --port auto --hide-welcome-screen\n"
    assert not seen()


def test_all_ends_with_its_window(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rerun_files, "program", lambda: script(tmp_path, "exit 0"))
    with looked_at(URL, SOURCE, browser=False, native=True) as seen:
        eventually(lambda: not seen())


def test_a_viewer_that_is_not_there_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing() -> Path:
        raise rerun_files.Missing("rerun's own viewer is not installed")

    monkeypatch.setattr(rerun_files, "program", missing)
    with (
        pytest.raises(Misconfigured, match="--native: rerun's own viewer is not installed"),
        looked_at(URL, SOURCE, browser=False, native=True),
    ):
        pass
