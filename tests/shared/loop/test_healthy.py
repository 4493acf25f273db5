"""The health check of a container: a process's own word, or that there is none."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from signal import SIGCONT, SIGSTOP

import pytest

from shared.loop import healthy
from tests.conftest import Router, StartProcess
from tests.support.ports import free_endpoint
from tests.support.processes import ROOT
from tests.support.wait import eventually


@pytest.fixture
def word(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    file = tmp_path / "health"
    monkeypatch.setenv("TANDEM_HEALTH", str(file))
    return file


def test_a_word_holds_until_the_next_one_or_until_it_is_old(word: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert healthy.trouble() == "it has not said yet how it is"
    healthy.tell("degraded", "sensor/ft: silent for 0.3 s: is it running?")
    assert healthy.trouble() == "degraded: sensor/ft: silent for 0.3 s: is it running?"
    healthy.tell("ok")
    assert healthy.trouble() == ""
    later = float(word.read_text().split()[0]) + healthy.FRESH
    monkeypatch.setattr(healthy.time, "monotonic", lambda: later + 0.1)
    assert healthy.trouble() == "it has said nothing for 3.1 s"


def test_where_nothing_can_be_written_the_process_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TANDEM_HEALTH", str(tmp_path / "absent" / "health"))
    healthy.tell("ok")
    assert healthy.trouble()
    monkeypatch.delenv("TANDEM_HEALTH")
    healthy.tell("ok")


def asked(word: Path) -> subprocess.CompletedProcess[str]:
    """The health check as the compose file has it."""
    return subprocess.run(
        [sys.executable, "-I", "-S", "shared/loop/healthy.py"],
        cwd=ROOT,
        env={**os.environ, "TANDEM_HEALTH": str(word)},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.processes
def test_a_service_is_healthy_once_it_is_fed_and_until_it_hangs(
    router: Router, start: StartProcess, tmp_path: Path
) -> None:
    word = tmp_path / "wrench"
    wrench = start("services.wrench", "--connect", router.endpoint, environment={"TANDEM_HEALTH": str(word)})
    eventually(lambda: asked(word).stdout.startswith("starting: waiting for sensor/ft: never received"), 30.0)
    mock = start("services.mock", "--connect", router.endpoint)
    eventually(lambda: asked(word).returncode == 0, 30.0, lambda: asked(word).stdout)
    mock.signal(SIGSTOP)
    eventually(lambda: asked(word).stdout.startswith("degraded: "), 30.0, lambda: asked(word).stdout)
    mock.signal(SIGCONT)
    wrench.signal(SIGSTOP)
    eventually(lambda: "it has said nothing for" in asked(word).stdout, 30.0, lambda: asked(word).stdout)
    wrench.signal(SIGCONT)


@pytest.mark.processes
def test_a_router_is_healthy_while_it_is_at_work(start: StartProcess, tmp_path: Path) -> None:
    word = tmp_path / "router"
    router = start("services.router", "--listen", free_endpoint(), environment={"TANDEM_HEALTH": str(word)})
    eventually(lambda: asked(word).returncode == 0, 30.0, lambda: asked(word).stdout)
    router.signal(SIGSTOP)
    eventually(lambda: asked(word).returncode == 1, 30.0)
    router.signal(SIGCONT)
