"""What a recording has of a service is enough to take its very steps again, whenever the recording heard it."""

from __future__ import annotations

import json
from contextlib import nullcontext
from pathlib import Path
from unittest.mock import Mock

import pytest

from services.cli import common
from services.experiment.replay import outcome
from services.experiment.replay.equality import Equality, equality, told
from services.experiment.replay.recorded import outputs, read
from services.experiment.replay.replay import complete, replay
from services.experiment.replay.subjects import SUBJECTS
from shared.parameters import Refused
from shared.topics import setup_topic
from shared.wire.log import Heard, Log, NoRecording
from tests.services.cli.command import tandem_here
from tests.services.experiment.replay.rig import Recorded


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Recorded:
    return Recorded(tmp_path_factory.mktemp("services"))


@pytest.fixture(scope="module")
def file(recorded: Recorded, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded.file(tmp_path_factory.mktemp("recording") / "recording.mcap")


def compared(path: Path, service: str) -> Equality:
    found = read([path], service)
    (life,) = found.lives
    return equality(life, replay(found, life, {}))


@pytest.mark.parametrize("service", SUBJECTS)
def test_every_answer_is_equal_to_the_last_bit(file: Path, service: str) -> None:
    found = compared(file, service)
    assert found.first is None
    assert found.equal == found.compared > (200 if service != "task" else 50)
    assert found.whole and (found.missing, found.lost, found.gaps, found.unheard) == (0, 0, 0, 0)
    assert told(service, found)[0] == f"{service}: {found.equal:,} of {found.compared:,} outputs equal to the last bit"


def test_one_bit_that_differs_is_named_with_both_values(recorded: Recorded, tmp_path: Path) -> None:
    heard = list(recorded.heard)
    where = max(index for index, one in enumerate(heard) if one.key == "command/ee_twist" and one.arrival_ns < 4e9)
    one = heard[where]
    bent = bytearray(one.payload)
    place = bent.index(b"linear") + len(b"linear") + 1 + 8  # the last byte of the first of three floats
    bent[place] ^= 1
    heard[where] = one._replace(payload=bytes(bent))
    found = compared(recorded.file(tmp_path / "a.mcap", heard), "controller")
    assert found.equal == found.compared - 1
    assert found.first is not None and (found.first.key, found.first.place) == ("command/ee_twist", "linear[0]")
    assert found.first.recorded != found.first.replayed == pytest.approx(found.first.recorded)
    assert found.from_on is not None and found.from_on > found.first.time


def test_of_a_service_that_ran_before_it_is_said_from_when_on_it_is_equal(recorded: Recorded, tmp_path: Path) -> None:
    late = [one for one in recorded.heard if one.arrival_ns > 2.5e9]
    path = recorded.file(tmp_path / "late.mcap", late)
    found = compared(path, "controller")
    # It rests until its inputs were healthy for half a second, and lowers a limit as what is felt lets it.
    assert not found.whole and found.from_on is not None and 0.5 < found.from_on < 3.0
    # What the wrench service keeps for its restart was told: the tare of before.
    zeroed = compared(path, "wrench")
    assert zeroed.equal > 0.95 * zeroed.compared and not zeroed.whole
    assert any("was running when the recording began" in line for line in told("controller", found))


def test_what_a_recording_missed_is_counted(recorded: Recorded, tmp_path: Path) -> None:
    def unheard(one: Heard) -> bool:
        return one.key == "wrench/external" and 3.0e9 < one.arrival_ns < 3.1e9

    gone = [one for one in recorded.heard if not unheard(one)]
    found = compared(recorded.file(tmp_path / "gap.mcap", gone), "controller")
    assert found.missing == len(recorded.heard) - len(gone) > 5
    assert found.equal < found.compared
    lost = compared(recorded.file(tmp_path / "gap.mcap", gone), "wrench")
    assert (lost.lost, lost.unheard, lost.equal) == (found.missing, found.missing, lost.compared)


def test_what_was_not_heard_is_said_again_by_replaying_who_said_it(recorded: Recorded, tmp_path: Path) -> None:
    gone = [one for one in recorded.heard if not (one.key == "wrench/external" and 3.0e9 < one.arrival_ns < 3.1e9)]
    found, again = complete([recorded.file(tmp_path / "gap.mcap", gone)], "controller")
    (life,) = found.lives
    compared = equality(life, replay(found, life, {}))
    assert again == len(recorded.heard) - len(gone) > 5
    assert compared.equal == compared.compared > 200 and compared.missing == 0


def test_without_a_word_on_what_a_service_took_it_is_refused(recorded: Recorded, tmp_path: Path) -> None:
    silent = [one for one in recorded.heard if one.key != setup_topic("wrench").key]
    with pytest.raises(NoRecording, match="nothing under setup/wrench"):
        read([recorded.file(tmp_path / "silent.mcap", silent)], "wrench")


def test_a_changed_parameter_holds_although_another_one_was_set_later(file: Path) -> None:
    found = read([file], "controller")
    (life,) = found.lives
    again = replay(found, life, {"max_linear": 0.01})
    figures = {one.name: one for one in outcome.figures(life.answers, again.answers)}
    speed = figures["command/ee_twist.linear: largest"]
    assert speed.recorded > 0.011 and speed.replayed == pytest.approx(0.01, abs=1e-6)
    first = outcome.first_difference(life.answers, again.answers)
    assert first is not None and first.key == "command/ee_twist" and first.place == "linear"


def test_another_limit_changes_its_share_and_how_long_it_is_exceeded(file: Path) -> None:
    found = read([file], "controller")
    (life,) = found.lives
    wide = outcome.limited({"force_limit": [250.0] * 3})
    again = replay(found, life, {}, wide)
    figures = {one.name: one for one in outcome.figures(life.answers, again.answers)}
    share = figures["force x: largest share of its limit"]
    assert share.recorded > 100.0 and share.replayed == pytest.approx(share.recorded / 10.0, rel=0.3)
    assert figures["force x: time over its limit"].recorded > 0.5
    assert figures["force x: time over its limit"].replayed == 0.0


def test_a_parameter_out_of_range_is_refused(file: Path) -> None:
    found = read([file], "wrench")
    with pytest.raises(Refused, match="lowpass_hz"):
        replay(found, found.lives[0], {"lowpass_hz": -1.0})


def test_the_command_says_what_is_equal_and_writes_what_would_have_been(
    file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    awaited = Mock(return_value=nullcontext())
    monkeypatch.setattr(common, "waiting", awaited)
    equal = tandem_here(capsys, "replay", str(file.parent), "--into", "wrench", "--json")
    assert " MB of recording are gone through" in awaited.call_args.args[0]
    (start,) = json.loads(equal.stdout)["starts"]
    assert equal.returncode == 0 and start["equal"] == start["compared"] > 0 and start["first"] is None
    out = tmp_path / "other.mcap"
    changed = tandem_here(
        capsys, "replay", str(file), "--into", "controller", "--force-limit", "5", "--out", str(out), "--json"
    )
    content = json.loads(changed.stdout)
    assert f"tandem view {file} --beside {out}" in changed.stderr
    assert changed.returncode == 0 and "open loop" in content["note"] and content["starts"][0]["first"]
    own = {topic.key for topic in outputs("controller")}
    before, after = ([one for one in Log(path) if one.key not in own] for path in (file, out))
    assert sorted(before) == sorted(after)
    assert len([one for one in Log(out) if one.key in own]) > 500
    assert compared(out, "wrench").equal == start["equal"]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--into", "sim"), "--into 'sim': choose from wrench, controller, base, task"),
        (("--into", "wrench", "--force-limit", "5"), "limits are the controller's"),
        (("--into", "controller", "--force-limit", "-5"), "force_limit"),
        (("--into", "controller", "--set", "max_linear"), "wanted NAME=VALUE"),
        (("--into", "controller", "--set", "nonsense=1"), "nonsense is no parameter"),
        (("--into", "controller", "--out", __file__), "test_replay.py: there already"),
        (("--into", "controller", "--out", "/dev/null/a.mcap"), "--out /dev/null: /dev/null is no folder"),
    ],
)
def test_what_it_cannot_take_is_refused_in_one_line(
    file: Path, options: tuple[str, ...], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    refused = tandem_here(capsys, "replay", str(file), *options)
    assert refused.returncode == 2 and words in refused.stderr and refused.stderr.count("\n") == 1


def test_a_recording_may_come_from_anybody(recorded: Recorded, tmp_path: Path) -> None:
    """A file that a service is said to have kept is put where the replay is, or nowhere."""
    from services.experiment.replay.subjects import make

    found = read([recorded.file(tmp_path / "a.mcap")], "wrench")
    setup = found.lives[0].told[0].setup
    inside = tmp_path / "inside"
    inside.mkdir()
    make("wrench", setup.replaced(files={"../outside": "x", "/tmp/outside-tandem": "x", "in": "x"}), {}, inside, float)
    assert (inside / "in").exists() and not (tmp_path / "outside").exists()
    assert not Path("/tmp/outside-tandem").exists()
