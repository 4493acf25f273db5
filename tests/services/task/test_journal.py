"""What a restart goes by: it comes back as it was, and whatever does not fit is refused with the reason."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from services.task.geometry import Pose
from services.task.journal import Journal, JournalEntry, judge
from services.task.machine import StateMachine
from services.task.parameters import TaskParameters
from services.task.states import Observation, State
from shared.messages import GripperState
from shared.parameters import Refused
from tests.services.task.toy import START, Toy

SETTINGS = TaskParameters()
TARGET = START.shifted(0.05)
ENTRY = JournalEntry(1, "carrying", START.row, TARGET.row, 1.5, -7.0, True, written=100.0)
FULL, EMPTY = GripperState(0.05, 12.0, True), GripperState(0.08, 0.0, False)


def seen(gripper: GripperState = FULL, session: int = 1, away: float = 0.0) -> Observation:
    return Toy().seen(gripper=gripper, session=session, tool=START.shifted(away))


def resumed(
    sight: Observation, entry: JournalEntry | None = ENTRY, problem: str = "", now: float = 110.0
) -> StateMachine:
    """A machine that has gone by what was read at a time [s]."""
    machine = StateMachine(SETTINGS)
    machine.resume(judge(entry, problem, sight, SETTINGS, now), sight)
    return machine


def test_it_comes_back_as_it_was(tmp_path: Path) -> None:
    Journal(tmp_path).write(1, ENTRY, 123.0)
    again = Journal(tmp_path).read(1)
    assert again is not None
    assert again.to_plain() == ENTRY.replaced(written=123.0).to_plain()
    kept = json.loads((tmp_path / "1.json").read_text())
    assert kept["version"] == 2 and list(kept)[1:] == list(ENTRY.to_plain()) and len(kept["home"]) == 7


def test_nothing_held_removes_it(tmp_path: Path) -> None:
    journal = Journal(tmp_path)
    assert journal.read(1) is None
    journal.write(1, ENTRY, 0.0)
    journal.write(1, None, 0.0)
    assert journal.read(1) is None and not journal.problem


def test_the_last_run_of_the_robot_is_found_and_goes_with_the_next_entry_or_without_one(tmp_path: Path) -> None:
    for session in range(5):
        Journal(tmp_path).write(session, ENTRY.replaced(session=session), 0.0)
        assert [path.name for path in tmp_path.iterdir()] == [f"{session}.json"]
    found = Journal(tmp_path).read(9)
    assert found is not None and found.session == 4
    Journal(tmp_path).write(9, None, 0.0)
    assert not list(tmp_path.iterdir()), "a carry that is over does not come back"


def rewritten(change: Callable[[str], str]) -> Callable[[Path], object]:
    return lambda path: path.write_text(change(path.read_text()))


def changed(**fields: object) -> Callable[[Path], object]:
    return rewritten(lambda text: json.dumps({**json.loads(text), **fields}))


def folder(path: Path) -> None:
    path.unlink()
    path.mkdir()


def dangling(path: Path) -> None:
    path.unlink()
    path.symlink_to(path.with_name("nothing"))


TORN: dict[str, Callable[[Path], object]] = {
    "empty": rewritten(lambda text: ""),
    "half": rewritten(lambda text: text[: len(text) // 2]),
    "list": rewritten(lambda text: "[]"),
    "number": rewritten(lambda text: "3"),
    "nested": rewritten(lambda text: "[" * 4000),
    "huge": rewritten(lambda text: " " * 10_000_000),
    "field missing": rewritten(lambda text: text.replace('"home"', '"house"')),
    "never written": rewritten(lambda text: text.replace('"written"', '"wrote"')),
    "null": changed(home=None),
    "text for a number": changed(nominal="heavy"),
    "NaN": changed(mass=float("nan")),
    "endless": changed(mass=10**400),
    "short pose": changed(target=[1.0, 2.0]),
    "no rotation": changed(home=[0.0] * 7),
    "unknown state": changed(state="flying"),
    "other version": changed(version=99),
    "folder": folder,
    "dangling link": dangling,
    "binary": lambda path: path.write_bytes(bytes(range(256))),
}


@pytest.mark.parametrize("name", TORN)
def test_whatever_lies_there_is_survived_and_told(tmp_path: Path, name: str) -> None:
    Journal(tmp_path).write(1, ENTRY, 0.0)
    TORN[name](tmp_path / "1.json")
    for number in range(9):
        (tmp_path / f"folder{number}.json").mkdir()
    journal = Journal(tmp_path)
    assert journal.read(1) is None
    assert "torn" in journal.problem and len(journal.problem) < 300
    machine = resumed(seen(), None, journal.problem)
    assert machine.state is State.HOLDING and machine.fingers.hold and "torn" in machine.reason
    machine = resumed(seen(EMPTY), None, journal.problem)
    assert machine.state is State.IDLE and "torn" in machine.reason


def test_full_disk_is_noted_and_changes_nothing_else(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("no folder")
    journal = Journal(tmp_path / "file")
    journal.write(1, ENTRY, 0.0)
    assert "cannot write" in journal.problem and "restart" in journal.problem


def test_without_a_folder_nothing_is_kept() -> None:
    journal = Journal(None)
    journal.write(1, ENTRY, 0.0)
    assert journal.read(1) is None


@pytest.mark.parametrize("state", ["carrying", "releasing"])
def test_in_the_middle_of_carrying_it_goes_on(state: str) -> None:
    machine = resumed(seen(), ENTRY.replaced(state=state))
    assert machine.state is State.CARRYING and machine.fingers.hold
    decision = machine.step(Toy().seen(gripper=FULL, tool=TARGET), (), 0.02)
    assert decision.target.near(TARGET, 0.051, 0.01) and decision.nominal == -7.0
    assert decision.gripper is not None and decision.gripper.opening == 0.0


HELD = {
    "far away": ({}, {"away": 0.5}, 110.0, "m and"),
    "before the lift": ({"state": "grasping"}, {}, 110.0, "grasping before its restart"),
    "already holding": ({"state": "holding"}, {}, 110.0, "holding before its restart"),
    "robot restarted": ({}, {"session": 2}, 110.0, "robot was restarted"),
    "old": ({}, {}, 221.0, "121 s old, allowed are 120 s"),
    "before a reboot": ({}, {}, 50.0, "before a reboot"),
    "before a reboot, by its name": ({"boot": "another"}, {}, 110.0, "before a reboot"),
    "another panel": ({"mass": 2.0}, {}, 110.0, "2 kg, panel_mass is 1.5 kg"),
}


@pytest.mark.parametrize("name", HELD)
def test_otherwise_a_full_gripper_is_held_where_it_is(name: str) -> None:
    entry, now_seen, now, words = HELD[name]
    sight = seen(**now_seen)
    machine = resumed(sight, ENTRY.replaced(**entry), now=now)
    assert machine.state is State.HOLDING and machine.fingers.hold
    assert words in machine.reason, machine.reason
    decision = machine.step(sight, (), 0.02)
    assert decision.target.near(sight.tool, 1e-9, 1e-7)
    assert decision.gripper is not None and decision.gripper.opening == 0.0
    assert machine.command("start") is State.CARRYING


def test_held_after_a_restart_it_is_turned_as_far_as_it_was() -> None:
    turned = START @ Pose.from_rpy((0.0, 0.0, 0.0), (0.8, 0.0, 0.0))
    sight = Toy().seen(gripper=FULL, session=2, tool=turned)
    machine = resumed(sight)
    assert machine.state is State.HOLDING and machine.rotation == pytest.approx(0.8)
    machine.command("start")
    machine.step(sight, (), 0.02)
    assert machine.state is State.CARRYING and machine.rotation == pytest.approx(0.8)
    assert machine.entry(None).home[:3] == pytest.approx(turned.position), "elsewhere it begins anew"


def test_an_abort_before_it_is_ready_is_not_undone_by_the_journal() -> None:
    machine = StateMachine(SETTINGS)
    for word in ("start", "release", "reset", "abort", "start", "release", "reset"):
        if word == "abort":
            assert machine.command(word) is State.HOLDING
            continue
        with pytest.raises(Refused, match="not yet"):
            machine.command(word)
    machine.resume(judge(ENTRY, "", seen(), SETTINGS, 110.0), seen())
    assert machine.state is State.HOLDING and "aborted" in machine.reason
    decision = machine.step(seen(), (), 0.02)
    assert not decision.base and decision.nominal == -7.0 and machine.fingers.hold
    assert machine.command("start") is State.CARRYING
    assert machine.step(seen(), (), 0.02).base


@pytest.mark.parametrize("session", [1, 2])
def test_with_an_empty_gripper_it_is_refused(session: int) -> None:
    sight = seen(EMPTY, session)
    machine = resumed(sight)
    assert machine.state is State.IDLE and not machine.fingers.hold
    assert "the gripper holds nothing now" in machine.reason
    assert machine.step(sight, (), 0.02).target is None
