"""What outlives the process: where the carry stands, in a small file, and whether a restart may go by it.

Times are the machine's steady clock, which goes on when the process does not, and begins anew at a reboot: so an entry
names the boot that it was written in.
"""

from __future__ import annotations

import json
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from services.task.geometry import Pose
from services.task.parameters import TaskParameters
from services.task.states import Observation, State
from shared.loop.files import write_whole
from shared.schema.fields import Boolean, Integer, Number, Quaternion, Text, Vector
from shared.schema.records import Record, of
from shared.spatial import Array

_VERSION = 2
_BOOT_ID = Path("/proc/sys/kernel/random/boot_id")
_LONGEST = 4096  # characters of a file that are read; a journal has a few hundred
_SHOWN = 100  # characters of a problem that are told
_UNREADABLE = (OSError, ValueError, RecursionError)
"""Whatever lies in the file: the task has to start, and to say what it found."""
_STATES = tuple(state.value for state in State)
_CARRIED_ON = (State.CARRYING.value, State.RELEASING.value)


class JournalEntry(Record):
    """One carry."""

    session: int = of(Integer(doc="of the robot process"))
    state: str = of(Text(choices=_STATES, doc="of the task"))
    home: Array = of(Vector("m", "the tool when the grasp was finished: position and quaternion", size=7))
    target: Array = of(Vector("m", "the last one sent: position and quaternion", size=7))
    mass: float = of(Number("kg", "of the panel"))
    nominal: float = of(Number("N", "nominal force along z"))
    supported: bool = of(Boolean(doc="whether the panel was lifted"))
    written: float = of(Number("s", "when, steady clock"), default=0.0)
    boot: str = of(Text(doc="of the machine, in which that clock runs; empty if it has no name"), default="")

    def check(self) -> None:
        """Refuse a pose without a rotation.

        Raises:
            InvalidField: with its norm.
        """
        for name, pose in (("home", self.home), ("target", self.target)):
            Quaternion().check(pose[3:], name)

    @property
    def home_pose(self) -> Pose:
        """The tool when the grasp was finished."""
        return Pose.from_row(self.home)

    @property
    def target_pose(self) -> Pose:
        """The last target sent."""
        return Pose.from_row(self.target)


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
        """The entry of this run, else that of the last one; None without one, with a ``problem`` if it is torn."""
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
            plain = json.loads(text)
            if not isinstance(plain, dict) or plain.get("version") != _VERSION:
                raise ValueError(f"no entry of version {_VERSION}")
            # They have defaults for an entry that is not written yet.
            if missing := {"written", "boot"} - plain.keys():
                raise ValueError(f"{min(missing)} is missing")
            return JournalEntry.from_plain(plain)
        except _UNREADABLE as problem:
            self.problem = f"the journal {what} is torn ({type(problem).__name__}: {str(problem)[:_SHOWN]})"
            return None

    def _files(self, session: int) -> list[Path]:
        """Every journal, the one to go by last."""
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
                write_whole(ours, self._text(entry, now))
            self.problem = ""
            if self._alone != session:
                self._leave_alone(session)
        except OSError as problem:
            text = f"cannot write {ours} ({problem.strerror})"
            self.problem = f"{text}: a restart would not know of the carry"

    def texts(self, session: int | None, entry: JournalEntry | None, now: float) -> dict[str, str]:
        """By name each file that a new start would find, if this entry were written now.

        Args:
            session: of the robot process; None as long as the task has not begun, and what is there counts.
            entry: None while nothing is held.
            now: steady clock [s].
        """
        if session is not None:
            return {} if entry is None else {self._path(session).name: self._text(entry, now)}
        found = {}
        with suppress(*_UNREADABLE):
            for path in self._files(0):
                with path.open(encoding="utf-8") as file:
                    found[path.name] = file.read(_LONGEST + 1)
        return found

    def _text(self, entry: JournalEntry, now: float) -> str:
        plain = entry.replaced(written=now, boot=self._boot).to_plain()
        return json.dumps({"version": _VERSION, **plain})

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
    entry: JournalEntry | None, problem: str, seen: Observation, parameters: TaskParameters, now: float, boot: str = ""
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
        return Resumption(kept=entry, reason="the robot was restarted meanwhile, its poses mean something else now")
    if entry.state not in _CARRIED_ON:
        return Resumption(kept=entry, reason=f"the task was {entry.state} before its restart")
    target = entry.target_pose
    if not seen.tool.near(target, parameters.resume_distance, parameters.resume_angle):
        away, turned = seen.tool.distance(target), seen.tool.angle(target)
        text = f"the tool is {away:.2f} m and {turned:.2f} rad from its last target"
        allowed = f"{parameters.resume_distance:g} m and {parameters.resume_angle:g} rad"
        return Resumption(kept=entry, reason=f"{text}, allowed are {allowed}")
    return Resumption(entry)
