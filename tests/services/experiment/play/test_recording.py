"""What is recorded can be read back, as arrays and as CSV, whatever the messages hold."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from services.experiment.play.recording import Recording
from shared import topics
from shared.clock import nanoseconds
from shared.messages import Header, Health, InputHealth, JointState
from shared.requests import Setup
from shared.schema.records import Record
from shared.sim_messages import BagState, SimWorld
from shared.wire.codec import decode_map, encode, encode_map
from shared.wire.log import Heard, write_log


def payload(message: Record, seq: int = 0) -> bytes:
    return encode(message, Header(seq, 1, seq, True))


def world(time: float, bag: BagState | None) -> bytes:
    return payload(SimWorld(time, None, bag, None, np.zeros(3), False))


def heard() -> list[Heard]:
    entries = [(topics.SIM_WORLD, 10.0, world(0.5, None)), (topics.SIM_WORLD, 11.0, world(1.5, BagState(2.0, 0.25)))]
    for time in (10.0, 10.5):
        joints = JointState(("a", "b"), np.array([time, 2.0]), np.zeros(2), np.zeros(2))
        entries.append((topics.STATE_JOINTS, time, payload(joints)))
    inputs = {"sensor/ft": InputHealth(0.01, 100.0, 0, True)}
    health = Health("ok", "", 100.0, 1.0, 2.0, 0, inputs)
    entries.append((topics.health_topic("wrench"), 10.2, payload(health)))
    return [Heard(topic.key, nanoseconds(time), data) for topic, time, data in entries]


ENDED = {"start": 10.0, "events": [(10.25, "start", ""), (12.0, "end", "done")]}


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """As the player of a run writes it."""
    path = tmp_path / "recording.mcap"
    write_log(path, {"robot": "tiago"}, heard(), run={"name": "run"}, end=ENDED)
    return path


@pytest.fixture
def recording(file: Path) -> Recording:
    return Recording.load(file)


def test_what_is_no_message_is_left_out_and_counted() -> None:
    ragged = encode_map(decode_map(world(0.0, None)) | {"contact_force": [1.0]})
    unsound = (b"", b"\xc1", payload(BagState(1.0, 1.0)), ragged)
    entries = [Heard("sim/world", 1, data) for data in unsound]
    entries.append(Heard("sim/world", nanoseconds(2.0), world(0.5, None)))
    recording = Recording.of({}, entries, {"start": 0.0, "events": []})
    assert recording.meta["rejected"] == {"sim/world": 4}
    assert recording.time("sim/world").tolist() == [2.0]


def test_what_a_service_works_by_is_no_series_whatever_lists_it_has() -> None:
    setups = [Setup({"zones": [{"reach": [1.0]}] * count}, (), {"a": "b"}, "", b"", (), b"") for count in range(3)]
    entries = [Heard("setup/controller", number, payload(one)) for number, one in enumerate(setups)]
    recording = Recording.of({}, [*entries, *heard()], ENDED)
    assert "setup/controller" not in recording.topics and not recording.meta["rejected"]


def test_times_and_events_count_from_the_start_not_from_a_field_called_time(recording: Recording) -> None:
    assert recording.time("sim/world").tolist() == [0.0, 1.0]
    assert recording.series("sim/world", "message_time").tolist() == [0.5, 1.5]
    assert [event.time for event in recording.events] == [0.25, 2.0]


def test_an_absent_part_is_nan_and_never_zero(recording: Recording) -> None:
    np.testing.assert_equal(recording.series("sim/world", "bag.height"), [np.nan, 0.25])
    assert "panel" not in recording.topics["sim/world"]


def test_the_newest_of_a_topic_is_what_was_said_last_and_before_that_the_first(recording: Recording) -> None:
    newest = recording.newest("state/joints", np.array([-1.0, 0.0, 0.49, 0.5, 9.0]), "position", "velocity")
    np.testing.assert_array_equal(newest[:, 0], [10.0, 10.0, 10.0, 10.5, 10.5])
    assert newest.shape == (5, 4)


def test_what_is_said_of_the_run_is_there(recording: Recording) -> None:
    assert {"robot": "tiago", "name": "run", "rejected": {}}.items() <= recording.meta.items()
    assert recording.series("state/joints", "name").tolist() == [["a", "b"]]


def test_csv_has_a_column_per_component(recording: Recording, tmp_path: Path) -> None:
    paths = {path.name: path for path in recording.write_csv(tmp_path)}
    assert set(paths) == {"sim_world.csv", "state_joints.csv", "health_wrench.csv", "events.csv"}
    with paths["state_joints.csv"].open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row["position.0"]) for row in rows] == [10.0, 10.5]
    assert [float(row["time"]) for row in rows] == [0.0, 0.5]
    with paths["health_wrench.csv"].open() as file:
        assert "sensor/ft" in next(csv.DictReader(file))["inputs"]


def test_what_is_missing_is_named(recording: Recording) -> None:
    with pytest.raises(KeyError, match="state/ee was not heard"):
        recording.time("state/ee")
    with pytest.raises(KeyError, match="no field 'force'"):
        recording.series("sim/world", "force")


def test_a_run_that_was_not_played_to_its_end_is_not_judged(tmp_path: Path) -> None:
    write_log(tmp_path / "unfinished.mcap", {}, heard(), run={"name": "run"})
    with pytest.raises(ValueError, match=r"unfinished.mcap: the run was not played to its end: play it again"):
        Recording.load(tmp_path / "unfinished.mcap")


def test_what_a_killed_player_left_is_no_whole_run(file: Path) -> None:
    whole = file.read_bytes()
    for kept in (0, 100, whole.index(b'"events"')):
        file.write_bytes(whole[:kept])
        with pytest.raises(ValueError, match=r"recording.mcap: .*: play .* again"):
            Recording.load(file)


def test_mere_text_and_nothing_are_no_recordings(tmp_path: Path) -> None:
    path = tmp_path / "other.mcap"
    path.write_text("not at all")
    with pytest.raises(ValueError, match=r"other.mcap: .*no recording"):
        Recording.load(path)
    with pytest.raises(FileNotFoundError):
        Recording.load(tmp_path / "none.mcap")
