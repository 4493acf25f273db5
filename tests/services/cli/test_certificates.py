"""What is said to whoever comes to a closed network with the wrong certificate, by commands and by processes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.conftest import StartProcess
from tests.services.cli.command import tandem_here
from tests.support.closed import make
from tests.support.ports import free_port
from tests.support.processes import Processes

pytestmark = pytest.mark.processes


@pytest.fixture(scope="module")
def keys(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make(tmp_path_factory.mktemp("keys") / "tiago")


@pytest.fixture(scope="module")
def endpoint(keys: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    endpoint = f"tls/127.0.0.1:{free_port()}"
    with Processes(tmp_path_factory.mktemp("router")) as processes:
        processes.start("services.router", "--listen", endpoint, "--secure", str(keys / "router")).wait_for_output(
            "listening"
        )
        yield endpoint


FORBIDDEN = (
    ("wrench/tare", "tare"),
    ("task/command", "task start"),
    ("wrench/parameters", "param get wrench"),
    ("control/parameters", "param set controller.law=paper"),
    ("control/parameters", "certify"),
    ("sim/command", "load 3"),
    ("sim/command", "reset"),
    ("control/target", "hold 0.5 -0.3 1 0 0 0"),
    ("control/target", "identify --yes"),
    ("stop", "stop"),
    ("stop", "resume"),
)


@pytest.mark.parametrize(("key", "command"), FORBIDDEN)
def test_what_a_certificate_may_not_do_is_said(
    key: str,
    command: str,
    endpoint: str,
    keys: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setenv("TANDEM_CONNECT", endpoint)
    monkeypatch.setenv("TANDEM_SECURE", str(keys / "viewer"))
    said = tandem_here(capsys, *command.split())
    assert said.returncode in (1, 2)
    word = "publish" if key in ("stop", "control/target") else "ask"
    # A stop is tried for a while all the same, and that is told.
    line = said.stderr.splitlines()[-1]
    assert line == f"tandem: the certificate of tiago.viewer may not {word} {key}; operator's may (TANDEM_SECURE)"


def test_whoever_is_refused_is_told_why(
    endpoint: str,
    keys: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setenv("TANDEM_CONNECT", endpoint)
    only = ("--only", "operator")
    for folder, why in {
        "": "is a closed network: name your certificates with TANDEM_SECURE=FOLDER",
        str(tmp_path / "none"): "authority.pem: No such file or directory; make it with `tandem keys`",
        str(
            make(tmp_path / "foreign", *only)
        ): "refused here: certificate signature failure (it is of another authority)",
        str(make(tmp_path / "old", *only, "--days", "0")): "expired on 20",
        str(make(tmp_path / "reem", *only, "--robot", "reem")): "the certificate is of reem.",
    }.items():
        monkeypatch.setenv("TANDEM_SECURE", folder and f"{folder}/operator")
        said = tandem_here(capsys, "status")
        (line,) = said.stderr.splitlines()
        assert (said.returncode, why in line) == (2, True), line
    monkeypatch.setenv("TANDEM_SECURE", str(keys / "operator"))
    monkeypatch.setenv("TANDEM_CONNECT", "tcp/127.0.0.1:7447")
    assert "wanted tls/<address>:<port>" in tandem_here(capsys, "status").stderr
    monkeypatch.setenv("TANDEM_CONNECT", f"tls/127.0.0.1:{free_port()}")
    said = tandem_here(capsys, "status")
    assert (said.returncode, "no router at tls/" in said.stderr) == (1, True)


def test_a_process_says_at_its_start_why_it_is_refused(
    endpoint: str, keys: Path, tmp_path: Path, start: StartProcess
) -> None:
    viewer, foreign = str(keys / "viewer"), str(make(tmp_path / "foreign", "--only", "wrench") / "wrench")
    for why, arguments in {
        "is of another authority": ("wrench", "--connect", endpoint, "--secure", foreign),
        "of tiago.viewer, wanted that of tiago.wrench": ("wrench", "--connect", endpoint, "--secure", viewer),
        "--listen tcp/127.0.0.1:7447: with certificates": ("router", "--secure", str(keys / "router")),
    }.items():
        start(f"services.{arguments[0]}", *arguments[1:]).refuses(why)
