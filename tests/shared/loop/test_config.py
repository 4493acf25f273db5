"""Options, environment and file: --set wins over the file, options over the environment, and a mistake is one line."""

from __future__ import annotations

from pathlib import Path

import pytest

from shared.loop.config import Misconfigured, complain, service_assignment, settings, value_of
from shared.loop.process import run
from shared.wire.endpoint import DEFAULT_ENDPOINT
from tests.shared.loop.rig import Recorder, RecorderParameters

pytestmark = pytest.mark.usefixtures("as_a_process")

CONFIG = """\
[task]
unknown = 1

[recorder]
gain = 2.0
limit = [1.0, 2.0, 3.0]
"""


@pytest.fixture
def config(tmp_path: Path) -> Path:
    path = tmp_path / "config.toml"
    path.write_text(CONFIG)
    return path


def chosen(*arguments: str):
    return settings("recorder", RecorderParameters, arguments)


def test_defaults() -> None:
    found = chosen()
    assert (found.robot, found.connect, found.parameters.gain) == ("tiago", DEFAULT_ENDPOINT, 1.0)


def test_a_file_gives_the_table_of_its_service(config: Path) -> None:
    assert chosen("--config", str(config)).parameters.limit == (1.0, 2.0, 3.0)


def test_set_wins_over_the_file_and_the_last_set_over_the_first(config: Path) -> None:
    found = chosen("--config", str(config), "--set", "gain=3", "--set", "gain = 4.5").parameters
    assert found.gain == 4.5 and found.limit == (1.0, 2.0, 3.0)


def test_settings_are_read_alike_wherever_they_are_typed() -> None:
    assert service_assignment(' controller.law = "paper" ') == ("controller", "law", '"paper"')
    assert [
        value_of(text) for text in ("paper", '"paper"', "two_words", "ros-2", "1e3", "true", "[1, 2]", "'a=b'")
    ] == [*("paper", "paper", "two_words", "ros-2", 1000.0, True, [1, 2], "a=b")]
    for text in ("2nd", "-x", "x.toml", "x y", ""):
        with pytest.raises(ValueError, match="is no TOML value"):
            value_of(text)
    for text in ("law=paper", "controller", "controller.law", "controller.=1", "controller.a.b=1", ".=", "x=a.b"):
        with pytest.raises(ValueError, match="is no"):
            service_assignment(text)


def test_the_environment_stands_in_for_options(config: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TANDEM_ROBOT", "reem")
    monkeypatch.setenv("TANDEM_CONNECT", "tcp/10.0.0.1:7000")
    monkeypatch.setenv("TANDEM_CONFIG", str(config))
    found = chosen()
    assert (found.robot, found.connect, found.parameters.gain) == ("reem", "tcp/10.0.0.1:7000", 2.0)
    found = chosen("--robot", "ari", "--connect", "tcp/127.0.0.1:1", "--set", "gain=5.0")
    assert (found.robot, found.connect, found.parameters.gain) == ("ari", "tcp/127.0.0.1:1", 5.0)
    monkeypatch.setenv("TANDEM_CONFIG", "")
    assert chosen().parameters.gain == 1.0


BAD = [
    (["--set", "gain=11.0"], "--set: gain is 11.0, allowed is 0 to 10 1/s"),
    (["--set", "limit=[1.0, -3.0, 1.0]"], "allowed is 0.1 to 50 N"),
    (["--set", "gain"], "wanted key=value"),
    (["--set", "=1"], "wanted key=value"),
    (["--set", "gain="], "not TOML"),
    (["--set", "gain=so fast"], "text needs quotes"),
    (["--set", "gain=fast"], "gain"),
    (["--set", 'gain="fast"'], "gain"),
    (["--set", "gain=true"], "gain"),
    (["--set", "gain=nan"], "gain"),
    (["--set", "gain=1e999"], "gain"),
    (["--set", "speed=1"], "speed is no parameter; there are gain, limit"),
    (["--set", "gain=" + "[" * 5000], "not TOML"),
    (["--set", "gain=1\nx=\n"], "not TOML"),
    (["--set", "gain=1\nx=2"], "not TOML"),
    (["--set"], "expected one argument"),
    (["--sett", "a=1"], "--sett"),
    (["stray"], "stray"),
    (["--robot", "two/chunks"], "letters, digits"),
    (["--robot", ""], "letters, digits"),
    (["--robot", "*"], "letters, digits"),
    (["--connect", "localhost:7447"], "wanted <protocol>/<address>:<port>"),
    (["--connect", "tcp/127.0.0.1:99999"], "port 1 to 65535"),
    (["--connect", "tcp/127.0.0.1:7447\nx"], "wanted <protocol>"),
    (["--connect", ""], "wanted <protocol>"),
    (["--config", "/nonexistent/x.toml"], "No such file"),
    (["--config", "/"], "Is a directory"),
]


@pytest.mark.parametrize(("arguments", "text"), BAD, ids=[" ".join(arguments)[:30] for arguments, _ in BAD])
def test_a_bad_option_is_status_two_and_one_line(
    arguments: list[str], text: str, capfd: pytest.CaptureFixture[str]
) -> None:
    status = run(lambda parameters: Recorder(), RecorderParameters, "recorder", arguments)
    output = capfd.readouterr()
    assert status == 2
    assert output.out == ""
    assert output.err.startswith("recorder: ") and output.err.count("\n") == 1
    assert text in output.err
    assert "Traceback" not in output.err


@pytest.mark.parametrize(
    ("content", "text"),
    [
        (b"[recorder]\ngain = 99.0\n", "gain is 99.0, allowed is 0 to 10 1/s"),
        (b"[recorder]\nspeed = 1\n", "speed is no parameter"),
        (b"recorder = 3\n", "wanted a table [recorder]"),
        (b"gain = 1.0\n", "outside a table"),
        (b"[contoller]\nlaw = 'paper'\n", "[contoller] is no service; there are sim, mock, "),
        (b"[recorder\n", "not TOML"),
        (b"\xff\xfe\x00", "not TOML"),
        (b"x = " + b"[" * 5000, "not TOML"),
        (b'[recorder]\n"a\\nb" = 1\n', "is no parameter"),
    ],
)
def test_a_bad_file_is_named_with_what_is_wrong(
    content: bytes, text: str, config: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config.write_bytes(content)
    with pytest.raises(Misconfigured) as caught:
        chosen("--config", str(config))
    assert complain("recorder", caught.value) == 2
    line = capsys.readouterr().err
    assert line.count("\n") == 1 and str(config) in line and text in line


def test_a_file_that_is_not_to_be_had_is_named_without_a_number(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(OSError) as caught:
        (tmp_path / "none").open()
    assert complain("recorder", caught.value) == 2
    assert capsys.readouterr().err == f"recorder: {tmp_path}/none: No such file or directory\n"


def test_help_is_no_mistake(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        chosen("--help")
    assert caught.value.code == 0
    assert "--config" in capsys.readouterr().out
