"""An exported recording, read by programs that know nothing of this project."""

from __future__ import annotations

import json
import math
from contextlib import nullcontext
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import msgpack
import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

from services.cli import common
from services.recorder.export import export
from shared import messages as m
from shared import sim_messages as sim
from shared import topics
from shared.messages import Header
from shared.schema.records import Record
from shared.spatial import rotation_matrix
from shared.wire.codec import encode
from shared.wire.log import Heard, write_log
from tests.services.cli.command import tandem_here

LEVEL = (0.0, 0.0, 0.0, 1.0)
ZERO = (0.0, 0.0, 0.0)
TURNED = (0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5))
PICTURE = m.CameraImage(4, 2, "mono8", bytes(range(8)), (5.0, 6.0, 2.0, 1.0), (), (0.1, 0.0, 1.2), LEVEL)
STATUS = ("certified", ZERO + ZERO, (1.0,) * 6, (0.0,) * 6, 0.0, 0.0, 0.0, (25.0,) * 3 + (10.0,) * 3, (0.0,) * 6)


def heard() -> list[Heard]:
    said: list[tuple[topics.Topic, Record]] = [
        (topics.STATE_BASE, m.BaseState((1.0, 2.0), math.pi / 2, ZERO)),
        (topics.STATE_EE, m.EndEffector((0.5, -0.3, 1.0), TURNED, ZERO, ZERO)),
        (topics.SENSOR_FT, m.FtSample(ZERO, ZERO, TURNED, (0.0, 0.1, 0.0), False)),
        (topics.SENSOR_CAMERA, PICTURE),
        (topics.STATE_JOINTS, m.JointState(("a", "b"), (0.1, 0.2), (0.0, 0.0), (0.0, 0.0))),
        (topics.CONTROL_TARGET, m.ControlTarget((0.5, 0.0, 1.0), LEVEL, (25.0,) * 3, (10.0,) * 3)),
        (topics.WRENCH_EXTERNAL, m.ExternalWrench((0.0, 0.0, -10.0), ZERO, (0.1,) * 6, "tare", "")),
        (topics.CONTROL_STATUS, m.ControlStatus("tracking", "", *STATUS)),
        (topics.CONTROL_STATUS, m.ControlStatus("yielding", "24.8 of 25 N", *STATUS)),
        (topics.CONTROL_STATUS, m.ControlStatus("yielding", "24.9 of 25 N", *STATUS)),
        (topics.CONTROL_STATUS, m.ControlStatus("braking", "sensor/ft is stuck", *STATUS)),
        (
            topics.SIM_WORLD,
            sim.SimWorld(
                1.0,
                sim.PanelState((1.0, 0.0, 0.9), LEVEL, (0.8, 0.5, 0.02)),
                sim.BagState(2.0, 0.4),
                sim.HandState((1.4, 0.0, 0.9), (1.0, 2.0, 3.0), ZERO),
                ZERO,
                True,
            ),
        ),
    ]
    entries = [
        Heard(topic.key, 10**9 + number, encode(message, Header(number, 7, number, True)))
        for number, (topic, message) in enumerate(said)
    ]
    return [*entries, Heard("sensor/ft", 10**9 + 50, b"noise"), Heard("a stranger's", 10**9 + 51, b"")]


Found = dict[str, list[Any]]


def read(path: Path) -> Found:
    """By topic, messages: JSON as maps, the rest as an independent decoder gives them."""
    found: Found = {}
    factory = DecoderFactory()
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            assert schema is not None
            if channel.message_encoding == "json":
                decoded = json.loads(message.data, parse_constant=pytest.fail)
                assert schema.encoding == "jsonschema" and set(json.loads(schema.data)["required"]) <= set(decoded)
            else:
                decode = factory.decoder_for(channel.message_encoding, schema)
                assert decode is not None
                decoded = decode(message.data)
            found.setdefault(channel.topic, []).append(decoded)
    return found


@pytest.fixture
def exported(tmp_path: Path) -> Found:
    write_log(tmp_path / "a.mcap", {"robot": "tiago", "wall_ns": 5 * 10**9}, heard())
    done = export([tmp_path / "a.mcap"], tmp_path / "fox.mcap")
    assert done.rejected == {"sensor/ft": 1, "a stranger's": 1}
    return read(tmp_path / "fox.mcap")


def test_every_number_of_every_message_can_be_plotted(exported: Found) -> None:
    for one in heard()[:-2]:
        wanted = {name: value for name, value in msgpack.unpackb(one.payload).items() if not isinstance(value, bytes)}
        assert wanted in exported[one.key], one.key


def test_frames_hang_together(exported: Found) -> None:
    frames = {one.child_frame_id: one for tf in exported["/tf"] for one in tf.transforms}
    assert {name: one.parent_frame_id for name, one in frames.items()} == {
        "base": "world",
        "tool": "base",
        "sensor": "base",
        "camera": "base",
    }
    turn = frames["base"].rotation
    np.testing.assert_allclose(rotation_matrix((turn.x, turn.y, turn.z, turn.w)) @ (1, 0, 0), (0, 1, 0), atol=1e-12)
    # The tool is 0.1 m along the sensor's y axis, which is -x of the base.
    sensor, tool = frames["sensor"].translation, frames["tool"].translation
    np.testing.assert_allclose((sensor.x - tool.x, sensor.y - tool.y, sensor.z), (0.1, 0.0, 1.0), atol=1e-12)


def test_pictures_come_with_their_lens(exported: Found) -> None:
    (image,), (lens,) = exported["/camera/image"], exported["/camera/calibration"]
    assert (image.width, image.height, image.step, image.data, image.frame_id) == (4, 2, 4, PICTURE.data, "camera")
    assert list(lens.K) == [5.0, 0.0, 2.0, 0.0, 6.0, 1.0, 0.0, 0.0, 1.0] and image.timestamp.seconds == 6


def test_the_scene_has_an_arrow_of_the_wrench_within_the_box_of_its_limits(exported: Found) -> None:
    entities = {entity.id: entity for update in exported["/scene"] for entity in update.entities}
    assert set(entities) == {"wrench", "limits", "panel", "hands", "bag"}
    force = entities["wrench"].arrows[0]
    turn = force.pose.orientation
    along = rotation_matrix((turn.x, turn.y, turn.z, turn.w)) @ (force.shaft_length + force.head_length, 0, 0)
    np.testing.assert_allclose(along, (0, 0, -0.15), atol=1e-9)
    heights = [point.z for point in entities["limits"].lines[0].points]
    assert (min(heights), max(heights)) == (pytest.approx(1.0 - 0.375), pytest.approx(1.0 + 0.375))
    assert entities["panel"].cubes[0].size.x == 0.8 and entities["panel"].frame_id == "world"


def test_the_log_tells_each_change_once(exported: Found) -> None:
    assert [(line.message, line.level, line.name) for line in exported["/log"]] == [
        ("tracking", 2, "control/status"),
        ("yielding: 24.8 of 25 N", 2, "control/status"),
        ("braking: sensor/ft is stuck", 3, "control/status"),
    ]


def test_joints_and_poses_have_types_of_their_own(exported: Found) -> None:
    assert [(joint.name, joint.position) for joint in exported["/joints"][0].joints] == [("a", 0.1), ("b", 0.2)]
    assert exported["/target"][0].pose.position.x == 0.5 and exported["/target"][0].frame_id == "base"


def test_numbered_files_are_one_recording(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    awaited = Mock(return_value=nullcontext())
    monkeypatch.setattr(common, "waiting", awaited)
    place = tmp_path / "record"
    place.mkdir()
    whole = heard()
    for number, part in enumerate((whole[:4], whole[4:8], whole[8:-2]), 1):
        write_log(place / f"tiago-{number:04d}.mcap", {"robot": "tiago"}, part)
    out, tables = tmp_path / "fox.mcap", tmp_path / "tables"
    done = tandem_here(capsys, "export", str(place), "--foxglove", str(out), "--csv", str(tables))
    assert done.returncode == 0, done.stderr
    assert sum(len(said) for name, said in read(out).items() if not name.startswith("/")) == len(whole) - 2
    assert (tables / "sim_world.csv").exists() and (tables / "sensor_ft.csv").exists()
    awaited.assert_called_with("0 MB of recording are gone through, which takes time; Ctrl-C ends it")
    again = tandem_here(capsys, "export", str(place), "--foxglove", str(out))
    assert again.returncode == 2 and "there already" in again.stderr


def test_an_interrupted_one_leaves_no_half_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_log(tmp_path / "a.mcap", {"robot": "tiago", "wall_ns": 5 * 10**9}, heard())
    monkeypatch.setattr("services.recorder.export.show", Mock(side_effect=KeyboardInterrupt))
    with pytest.raises(KeyboardInterrupt):
        export([tmp_path / "a.mcap"], tmp_path / "fox.mcap")
    assert [path.name for path in tmp_path.iterdir()] == ["a.mcap"]
