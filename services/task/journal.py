"""What outlives the process: where the carry stands, in a small file, and whether a restart may go by it.

Times are the machine's steady clock, which goes on when the process does not, and begins anew at a reboot: so an entry
names the boot that it was written in.
"""

from __future__ import annotations

import json
import math
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from services.task.geometry import Pose
from services.task.parameters import TaskParameters
from services.task.states import Observation, State
from shared.loop.files import write_whole

_VERSION = 2
_BOOT_ID = Path("/proc/sys/kernel/random/boot_id")
_LONGEST = 4096
"""Characters of a file that is read at most; a journal has a few hundred."""
_SHOWN = 100
"""Characters of a problem that are told."""
_UNREADABLE = (OSError, ValueError, LookupError, TypeError, AttributeError, ArithmeticError, RecursionError)
"""Whatever lies in the file: the task has to start, and to say what it found."""


@dataclass(frozen=True, eq=False)
class JournalEntry:
    """One carry.

    Attributes:
        session: of the robot process.
        state: of the task.
        home: the tool when the grasp was finished.
        target: the last one sent.
        mass: of the panel [kg].
        nominal: nominal force along z [N].
        supported: whether the panel was lifted.
        written: when, steady clock [s].
        boot: of the machine, in which that clock runs; "" if it has no name.
    """

    session: int
    state: State
    home: Pose
    target: Pose
    mass: float
    nominal: float
    supported: bool
    written: float = 0.0
    boot: str = ""


@dataclass(frozen=True, eq=False)
class Resumption:
    """What a restart makes of its journal.

    Attributes:
        entry: to go on from, without a jump.
        kept: what is known of a carry that can only be held where the tool is now.
        reason: why there is no ``entry``; empty without a journal.
    """

    entry: JournalEntry | None = None
    kept: JournalEntry | None = None
    reason: str = ""


class Journal:
    """One file, named after the run of the robot process that it is of.

    Args:
        folder: of one robot alone: all that lies there is of its runs. None keeps nothing.
        boot: name of the machine's present boot.

    Attributes:
        problem: why the last access failed, empty if it did not.
    """

    def __init__(self, folder: Path | None, boot: str = "") -> None:
        self._folder = folder
        self._boot = boot
        self._alone: int | None = None
        self.problem = ""

    def read(self, session: int) -> JournalEntry | None:
        """The entry of this run, else that of the last one; None without any, with a ``problem`` if it is torn."""
        if self._folder is None:
            return None
        what: Path = self._folder
        try:
            found = self._files(session)
            if not found:
                return None
            what = found[-1]
            if not what.is_file():
                raise OSError("no file")
            with what.open(encoding="utf-8") as file:
                text = file.read(_LONGEST + 1)
            if len(text) > _LONGEST:
                raise ValueError(f"more than {_LONGEST} characters")
            return _entry(json.loads(text))
        except _UNREADABLE as problem:
            self.problem = f"the journal {what} is torn ({type(problem).__name__}: {str(problem)[:_SHOWN]})"
            return None

    def _files(self, session: int) -> list[Path]:
        """All journals, the one to go by last."""
        assert self._folder is not None
        if not self._folder.is_dir():
            return []
        ours = self._path(session)
        files = [path for path in self._folder.glob("*.json") if path == ours or path.is_file()]
        return sorted(files, key=lambda path: (path == ours, path.lstat().st_mtime))

    def write(self, session: int, entry: JournalEntry | None, now: float) -> None:
        """Replace the file in one step, or remove it; a full disk is noted in ``problem`` and changes nothing else.

        What earlier runs of the robot have left goes with it: a carry that is over must not come back.
        """
        if self._folder is None:
            return
        ours = self._path(session)
        try:
            if entry is None:
                ours.unlink(missing_ok=True)
            else:
                write_whole(ours, json.dumps(_plain(entry, now, self._boot)))
            self.problem = ""
            if self._alone != session:
                self._leave_alone(session)
        except OSError as problem:
            text = f"cannot write {ours} ({problem.strerror})"
            self.problem = f"{text}: a restart would not know of the carry"

    def _leave_alone(self, session: int) -> None:
        """Remove what is not of this session; once is enough, since nobody else writes here."""
        for path in self._files(session):
            if path != self._path(session):
                with suppress(OSError):
                    path.unlink()
        self._alone = session

    def _path(self, session: int) -> Path:
        assert self._folder is not None
        return self._folder / f"{session}.json"


def boot_id() -> str:
    """Name of the machine's present boot; "" if it has none."""
    try:
        return _BOOT_ID.read_text(encoding="ascii").strip()
    except (OSError, ValueError):
        return ""


def judge(
    entry: JournalEntry | None,
    problem: str,
    seen: Observation,
    parameters: TaskParameters,
    now: float,
    boot: str = "",
) -> Resumption:
    """Whether a restart may go by what it read.

    Args:
        entry: as read.
        problem: why it could not be read.
        seen: at the first step; the gripper is known.
        parameters: of this process.
        now: steady clock [s].
        boot: of the machine.
    """
    assert seen.gripper is not None
    if entry is None:
        return Resumption(reason=problem)
    if not seen.gripper.holding:
        whose = "another run of the robot" if entry.session != seen.session else "this run"
        return Resumption(reason=f"the journal is of a carry in {whose}, and the gripper holds nothing now")
    age = now - entry.written
    if entry.boot != boot or age < 0.0:
        return Resumption(kept=entry, reason="the journal is from before a reboot")
    if age > parameters.journal_max_age:
        how = f"{age:.0f} s old, allowed are {parameters.journal_max_age:g} s"
        return Resumption(kept=entry, reason=f"the journal is {how}")
    if entry.mass != parameters.panel_mass:
        what = f"of a panel of {entry.mass:g} kg, panel_mass is {parameters.panel_mass:g} kg"
        return Resumption(kept=entry, reason=f"the journal is {what}")
    if entry.session != seen.session:
        return Resumption(
            kept=entry, reason="the robot was restarted meanwhile, its poses mean something else now"
        )
    if entry.state not in (State.CARRYING, State.RELEASING):
        return Resumption(kept=entry, reason=f"the task was {entry.state.value} before its restart")
    if not seen.tool.near(entry.target, parameters.resume_distance, parameters.resume_angle):
        away = seen.tool.distance(entry.target)
        text = f"the tool is {away:.2f} m and {seen.tool.angle(entry.target):.2f} rad from its last target"
        allowed = f"{parameters.resume_distance:g} m and {parameters.resume_angle:g} rad"
        return Resumption(kept=entry, reason=f"{text}, allowed are {allowed}")
    return Resumption(entry)


def _plain(entry: JournalEntry, now: float, boot: str) -> dict[str, Any]:
    return {
        "version": _VERSION,
        "session": entry.session,
        "state": entry.state.value,
        "home": _plain_pose(entry.home),
        "target": _plain_pose(entry.target),
        "mass": entry.mass,
        "nominal": entry.nominal,
        "supported": entry.supported,
        "written": now,
        "boot": boot,
    }


def _plain_pose(pose: Pose) -> list[float]:
    return [*pose.position.tolist(), *pose.orientation.tolist()]


def _entry(plain: dict[str, Any]) -> JournalEntry:
    if plain["version"] != _VERSION:
        raise ValueError(f"version {plain['version']}")
    session, supported, boot = plain["session"], plain["supported"], plain["boot"]
    if not isinstance(session, int) or not isinstance(supported, bool) or not isinstance(boot, str):
        raise TypeError("session, supported or boot")
    return JournalEntry(
        session=session,
        state=State(plain["state"]),
        home=_pose(plain["home"]),
        target=_pose(plain["target"]),
        mass=_number(plain["mass"]),
        nominal=_number(plain["nominal"]),
        supported=supported,
        written=_number(plain["written"]),
        boot=boot,
    )


def _pose(plain: list[Any]) -> Pose:
    values = [_number(value) for value in plain]
    if len(values) != 7:
        raise ValueError(f"a pose of {len(values)} numbers")
    return Pose.of(values[:3], values[3:])


def _number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise ValueError(f"{value!r} is no number")
    return float(value)
