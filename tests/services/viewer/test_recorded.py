"""Recordings on one time axis: the parts of one as one, other runs after it, killed ones as far as they go."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from services.viewer.blueprint import SIDES
from services.viewer.recorded import GAP, draw
from services.viewer.stream import Stream
from shared import topics as t
from shared.clock import nanoseconds
from shared.messages import Header
from shared.wire.codec import encode
from shared.wire.log import Heard, Log, NoRecording, write_log
from tests.services.viewer.drawn import Drawn
from tests.services.viewer.messages import camera, wrench

FRAME = "Transform3D:child_frame"


def record(path: Path, begin: float, duration: float, session: int = 1, seq: int = 0) -> Path:
    """A recording of a wrench at 100 Hz, by a clock that shows this time [s] at its beginning."""
    path.parent.mkdir(parents=True, exist_ok=True)
    heard = []
    for number in range(round(duration * 100)):
        now = nanoseconds(begin + 0.01 * number)
        header = Header(seq + number, session, now, True)
        heard.append(Heard(t.WRENCH_EXTERNAL.key, now, encode(wrench(float(number)), header)))
    heard.insert(1, Heard("unknown/key", nanoseconds(begin), b"\xc1"))
    heard.insert(1, Heard(t.TASK_STATUS.key, nanoseconds(begin), b"no message"))
    write_log(path, {"robot": "tiago"}, heard)
    return path


def shown(tmp_path: Path, *runs: list[Path]) -> tuple[float, list[tuple[float, float]], list[str]]:
    """How long what is drawn lasts, time and value of the curve of z, and the notes."""
    with Stream.written(tmp_path / "drawn.rrd") as stream:
        lasts = draw(stream.rec, runs)
    drawn = Drawn(tmp_path / "drawn.rrd")
    curve = [(time, value[0]) for time, value in drawn.of("curves/wrench/fz", "Scalars:scalars")]
    notes = [text for _, (text,) in drawn.of("why/history", "TextLog:text") if text.endswith("begins")]
    return lasts, curve, notes


def test_all_of_it_is_drawn_from_its_beginning(tmp_path: Path) -> None:
    lasts, curve, notes = shown(tmp_path, [record(tmp_path / "run" / "a.mcap", 5000.0, 2.0)])
    assert lasts == pytest.approx(1.99)
    assert [value for _, value in curve] == list(range(200))
    assert curve[0][0] == 0.0 and curve[-1][0] == pytest.approx(1.99)
    assert notes == ["run/a.mcap begins"]


def test_parts_of_one_recording_go_on_where_the_one_before_ended(tmp_path: Path) -> None:
    parts = [record(tmp_path / "a-1.mcap", 100.0, 1.0), record(tmp_path / "a-2.mcap", 101.0, 1.0, seq=100)]
    lasts, curve, _ = shown(tmp_path, parts)
    assert lasts == pytest.approx(1.99) and len(curve) == 200


@pytest.mark.parametrize("begin", [3.0, 9000.0], ids=["another machine's clock", "hours later"])
def test_another_run_comes_after_it(tmp_path: Path, begin: float) -> None:
    runs = [record(tmp_path / "a.mcap", 100.0, 1.0), record(tmp_path / "b.mcap", begin, 1.0, session=2)]
    lasts, curve, notes = shown(tmp_path, *([run] for run in runs))
    assert len(curve) == 200 and lasts == pytest.approx(0.99 + GAP + 0.99)
    assert curve[100][0] - curve[99][0] == pytest.approx(GAP) and len(notes) == 2


def test_one_that_was_killed_is_drawn_as_far_as_it_goes(tmp_path: Path) -> None:
    whole = record(tmp_path / "a.mcap", 100.0, 4.0)
    # Pictures that cannot be packed fill a part of the file each.
    heard = [*Log(whole)]
    for number in range(0, 400, 100):
        picture = encode(camera(data=random.randbytes(1 << 20)), Header(number, 1, heard[number].arrival_ns, True))
        heard.insert(number, Heard(t.SENSOR_CAMERA.key, heard[number].arrival_ns, picture))
    write_log(whole, {"robot": "tiago"}, heard)
    whole.write_bytes(whole.read_bytes()[: whole.stat().st_size // 2])
    _, curve, _ = shown(tmp_path, [whole])
    assert len(curve) in range(50, 300)


def test_it_can_be_broken_off(tmp_path: Path) -> None:
    with Stream.written(tmp_path / "drawn.rrd") as stream:
        lasts = draw(stream.rec, [[record(tmp_path / "a.mcap", 100.0, 5.0)]], lambda time: time < 1.0)
    assert lasts == pytest.approx(1.0, abs=0.15)


def test_two_are_drawn_beside_each_other_on_one_axis(tmp_path: Path) -> None:
    one, other = record(tmp_path / "a.mcap", 100.0, 1.0), record(tmp_path / "b.mcap", 5000.0, 2.0)
    with Stream.written(tmp_path / "drawn.rrd") as stream:
        lasts = [draw(stream.rec, [[path]], side=side) for path, side in zip((one, other), SIDES, strict=True)]
    drawn = Drawn(tmp_path / "drawn.rrd")
    assert lasts == [pytest.approx(0.99), pytest.approx(1.99)]
    curves = [drawn.of(f"{side}{side and '/'}curves/wrench/fz", "Scalars:scalars") for side in SIDES]
    assert [(len(curve), curve[0][0]) for curve in curves] == [(100, 0.0), (200, 0.0)]
    # Each robot hangs on its own base by frames of its own.
    roots = [drawn.last(f"{side}{side and '/'}tf/root", "Transform3D:parent_frame") for side in SIDES]
    assert roots == [["tf#/world/base"], ["tf#/beside/world/base"]]
    frames = [{row[1][0] for row in drawn.of(f"{side}{side and '/'}tf/static", FRAME)} for side in SIDES]
    assert frames[0] and frames[1] == {f"beside{name}" for name in frames[0]}


def test_what_is_no_recording_is_told(tmp_path: Path) -> None:
    other = tmp_path / "other.mcap"
    other.write_bytes(b"something else")
    with pytest.raises(NoRecording, match=r"other\.mcap"):
        shown(tmp_path, [other])
