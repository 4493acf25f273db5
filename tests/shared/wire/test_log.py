"""Recordings: byte for byte what was given, readable after a kill, bounded on the disk."""

from __future__ import annotations

import json
import math
import os
from pathlib import Path

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from mcap.reader import make_reader

from shared.topics import TOPICS, health_topic
from shared.wire.log import ABOUT, Heard, Log, LogWriter, NoRecording, recordings, write_log
from tests.support.wait import eventually

KEYS = st.sampled_from(("sensor/ft", "health/wrench", "a stranger's"))
ENTRIES = st.lists(st.builds(Heard, KEYS, st.integers(0, 2**60), st.binary(max_size=300)), max_size=40)


@given(entries=ENTRIES)
def test_what_is_written_is_read_in_its_order(entries: list[Heard], tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.mktemp("log") / "a.mcap"
    write_log(path, {"robot": "tiago"}, entries, end={"start": 1.5})
    log = Log(path)
    assert list(log) == entries
    assert log.about[ABOUT]["robot"] == "tiago" and log.about["end"] == {"start": 1.5}
    assert list(Log(path, keys={"sensor/ft"})) == [entry for entry in entries if entry.key == "sensor/ft"]


def test_a_writer_writes_what_it_is_given_and_readers_of_mcap_see_the_contract(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    log = LogWriter(path, {"robot": "tiago"})
    given_ = [Heard(topic.key, 1000 + number, bytes([number])) for number, topic in enumerate(TOPICS)]
    given_.append(Heard(health_topic("wrench").key, 5000, b"x"))
    for entry in given_:
        log.take(*entry)
    log.note("end", {"events": []})
    log.close()
    assert (log.heard, log.lost, log.problem) == (len(given_), 0, "")
    assert list(Log(path)) == given_
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    schemas = {schema.name: json.loads(schema.data) for schema in summary.schemas.values()}
    assert set(schemas) == {topic.message.__name__ for topic in (*TOPICS, health_topic("wrench"))}
    force = schemas["FtSample"]["properties"]["force"]
    assert (force["type"], force["minItems"], force["maxItems"]) == ("array", 3, 3) and "[N]" in force["description"]
    assert {"seq", "session", "stamp", "valid", "force"} <= set(schemas["FtSample"]["required"])


def test_what_is_said_of_it_is_json_for_every_reader(tmp_path: Path) -> None:
    write_log(tmp_path / "run.mcap", {}, [], end={"lasts": math.inf})
    with (tmp_path / "run.mcap").open("rb") as file:
        said = {
            one.name: json.loads(one.metadata["json"], parse_constant=pytest.fail)
            for one in make_reader(file).iter_metadata()
        }
    assert said["end"] == {"lasts": None}


def test_what_was_heard_a_moment_ago_is_on_the_disk_without_an_end(tmp_path: Path) -> None:
    path, copy = tmp_path / "a.mcap", tmp_path / "copy.mcap"
    log = LogWriter(path, {})

    def there() -> bool:
        # As what a killed writer leaves.
        copy.write_bytes(path.read_bytes())
        return bool(copy.stat().st_size) and list(Log(copy)) == [Heard("sensor/ft", 7, b"sample")]

    log.take("sensor/ft", 7, b"sample")
    eventually(there)
    log.close()


@example(share=1.0, flips=[134])
@example(share=1.0, flips=[137])
@given(share=st.floats(0.0, 1.0), flips=st.lists(st.integers(0, 10**6), max_size=3))
def test_a_damaged_file_gives_what_it_holds_or_is_refused_in_one_line(
    share: float, flips: list[int], tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.mktemp("log") / "a.mcap"
    entries = [Heard("sensor/ft", number, bytes(50)) for number in range(100)]
    write_log(path, {}, entries)
    whole = bytearray(path.read_bytes())[: round(share * path.stat().st_size)]
    for flip in flips:
        if whole:
            whole[flip % len(whole)] ^= 0xFF
    path.write_bytes(whole)
    try:
        found = list(Log(path))
    except NoRecording as problem:
        assert str(path) in str(problem) and "\n" not in str(problem)
    else:
        assert flips or found == entries[: len(found)]


def test_a_bounded_recording_drops_its_oldest_part(tmp_path: Path) -> None:
    most = 200_000
    log = LogWriter(tmp_path / "tiago.mcap", {"robot": "tiago"}, most)

    def filled() -> bool:
        for _ in range(20):
            log.take("sensor/ft", log.heard, os.urandom(1000))
        return not (tmp_path / "tiago-0001.mcap").exists()

    eventually(filled, 60.0)
    log.close()
    assert not log.lost
    files = sorted(tmp_path.iterdir())
    numbers = [entry.arrival_ns for file in files for entry in Log(file)]
    assert numbers == list(range(numbers[0], log.heard)) and numbers[0] > 0
    assert all(Log(file).about[ABOUT]["robot"] == "tiago" for file in files)
    assert len(files) <= 8


def test_a_full_disk_is_said_and_nobody_waits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log = LogWriter(tmp_path / "a.mcap", {})

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(log._file, "flush", full)
    eventually(lambda: log.take("sensor/ft", 1, b"x") or log.problem)
    assert log.problem == f"{tmp_path / 'a.mcap'}: No space left on device"
    eventually(lambda: log.take("sensor/ft", 1, b"x") or log.lost)
    log.close()


def test_a_file_that_is_there_is_not_written_over(tmp_path: Path) -> None:
    (tmp_path / "a.mcap").write_text("mine")
    with pytest.raises(FileExistsError):
        LogWriter(tmp_path / "a.mcap", {})
    assert (tmp_path / "a.mcap").read_text() == "mine"


def test_numbered_files_are_one_recording(tmp_path: Path) -> None:
    for name in ("a/tiago-0002", "a/tiago-0001", "b/recording", "b/reem-0001"):
        path = tmp_path / f"{name}.mcap"
        path.parent.mkdir(exist_ok=True)
        path.touch()
    assert [[path.stem for path in paths] for paths in recordings(tmp_path)] == [
        ["tiago-0001", "tiago-0002"],
        ["recording"],
        ["reem-0001"],
    ]
    assert recordings(tmp_path / "a/tiago-0002.mcap") == [[tmp_path / "a/tiago-0002.mcap"]]
    for nothing in (tmp_path / "none", tmp_path / "none.mcap"):
        with pytest.raises(NoRecording, match="not there"):
            recordings(nothing)
