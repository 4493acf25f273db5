"""What is recorded can be read back, as arrays and as CSV, whatever the messages hold."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from services.experiment.play.recording import Event, Recorder, Recording
from shared import topics
from shared.messages import Header, Health, InputHealth, JointState
from shared.schema.records import Record
from shared.sim_messages import BagState, SimWorld
from shared.wire.codec import decode_map, encode, encode_map


def payload(message: Record, seq: int = 0) -> bytes:
    return encode(message, Header(seq, 1, seq, True))


def world(time: float, bag: BagState | None) -> bytes:
    return payload(SimWorld(time, None, bag, None, np.zeros(3), False))


@pytest.fixture
def recording() -> Recording:
    recorder = Recorder()
    recorder.heard(topics.SIM_WORLD, 10.0, world(0.5, None))
    recorder.heard(topics.SIM_WORLD, 11.0, world(1.5, BagState(2.0, 0.25)))
    for time in (10.0, 10.5):
        joints = JointState(("a", "b"), np.array([time, 2.0]), np.zeros(2), np.zeros(2))
        recorder.heard(topics.STATE_JOINTS, time, payload(joints))
    inputs = {"sensor/ft": InputHealth(0.01, 100.0, 0, True)}
    health = Health("ok", "", 100.0, 1.0, 2.0, 0, inputs)
    recorder.heard(topics.health_topic("wrench"), 10.2, payload(health))
    return recorder.finish({"name": "run"}, [Event(10.25, "start"), Event(12.0, "end", "done")], start=10.0)


def test_what_is_no_message_is_left_out_and_counted() -> None:
    recorder = Recorder()
    for garbage in (b"", b"\xc1", payload(BagState(1.0, 1.0))):
        recorder.heard(topics.SIM_WORLD, 1.0, garbage)
    ragged = encode_map(decode_map(world(0.0, None)) | {"contact_force": [1.0]})
    recorder.heard(topics.SIM_WORLD, 1.5, ragged)
    recorder.heard(topics.SIM_WORLD, 2.0, world(0.5, None))
    recording = recorder.finish({}, [], start=0.0)
    assert recording.meta["rejected"] == {"sim/world": 4}
    assert recording.time("sim/world").tolist() == [2.0]


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


def test_survives_saving(recording: Recording, tmp_path: Path) -> None:
    recording.save(tmp_path / "run.npz")
    again = Recording.load(tmp_path / "run.npz")
    assert again.meta == recording.meta
    assert again.events == recording.events
    assert again.topics.keys() == recording.topics.keys()
    for key, columns in recording.topics.items():
        for name, values in columns.items():
            np.testing.assert_array_equal(again.topics[key][name], values)
    assert again.series("state/joints", "name").tolist() == [["a", "b"]]


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


@pytest.mark.parametrize("kept", [0.0, 0.5, 0.98], ids=("nothing", "half", "most"))
def test_a_damaged_recording_is_refused_by_name(recording: Recording, tmp_path: Path, kept: float) -> None:
    path = tmp_path / "recording.npz"
    recording.save(path)
    whole = path.read_bytes()
    path.write_bytes(whole[: int(kept * len(whole))])
    with pytest.raises(ValueError, match=r"recording.npz is damaged or no recording .*play the run again"):
        Recording.load(path)


def test_another_archive_and_mere_text_are_no_recordings(tmp_path: Path) -> None:
    path = tmp_path / "other.npz"
    np.savez(path, values=np.zeros(3))
    with pytest.raises(ValueError, match="no recording"):
        Recording.load(path)
    path.write_text("not at all")
    with pytest.raises(ValueError, match="no recording"):
        Recording.load(path)
    with pytest.raises(FileNotFoundError):
        Recording.load(tmp_path / "none.npz")
