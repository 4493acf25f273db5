"""What outlives the process: the file of an identified payload, and the journal of the present compensation.

The journal makes a restarted process continue where the killed one stopped: with a bag on the tool nobody could tare.
An entry belongs to one run of the robot process, named by the session of its samples. So does the zero in it, whose age
the stamps of that session tell; an identified payload belongs to the robot, and outlives the run.
"""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

from services.wrench.compensation import Compensation
from services.wrench.identification import IdentifiedPayload
from shared.loop.files import write_whole
from shared.parameters import Refused
from shared.schema.fields import Integer, InvalidField, Text
from shared.schema.records import Nullable, Record, RecordOf, of

JOURNAL, PAYLOAD = "wrench.json", "payload.toml"
"""Their names in the folder of a robot."""
_ENTRIES = 8  # runs of the robot process of which the journal is kept


def payload_text(result: IdentifiedPayload) -> str:
    """An identified payload as TOML."""
    lines = ["# Weight beyond the force-torque sensor and the sensor's bias: SI units, sensor axes."]
    lines += [f"{name} = {value}" for name, value in result.to_plain().items()]
    return "\n".join(lines) + "\n"


def save_payload(path: Path, result: IdentifiedPayload) -> None:
    """Write an identified payload as TOML.

    Raises:
        Refused: if the file cannot be written.
    """
    try:
        write_whole(path, payload_text(result))
    except OSError as problem:
        raise Refused(f"cannot write the payload to {path}: {problem.strerror}") from None


def load_payload(path: Path) -> IdentifiedPayload:
    """Read what ``save_payload`` wrote.

    Raises:
        Refused: if there is no such file or it holds something else; one line.
    """
    try:
        found = IdentifiedPayload.from_plain(tomllib.loads(path.read_text(encoding="utf-8")))
        found.compensation()  # its products have to be finite too
        return found
    except OSError as problem:
        raise Refused(f"payload {path}: {problem.strerror}; `tandem identify` makes such a file") from None
    except InvalidField as problem:
        raise Refused(f"payload {path}: {problem}; make the file anew with `tandem identify`") from None
    except (ValueError, RecursionError) as problem:
        raise Refused(f"payload {path}: not TOML ({problem})") from None


class JournalEntry(Record):
    """What was in force in one run of the robot process."""

    payload: str = of(Text(longest=4096, doc="value of the parameter of that name"))
    compensation: Compensation = of(RecordOf(record=Compensation))
    since: int | None = of(
        Nullable("ns", "stamp of the sample with which measuring its bias began, null without a zero", kind=Integer())
    )


class Journal:
    """The compensation in force, per run of the robot process, in one small file.

    Args:
        path: the file; None keeps nothing.
    """

    def __init__(self, path: Path | None = None) -> None:
        self._path = path
        self.problem = ""

    def _entries(self) -> dict[str, Any]:
        if self._path is None or not self._path.exists():
            return {}
        try:
            entries = json.loads(self._path.read_text(encoding="utf-8"))
        except (OSError, ValueError, RecursionError) as problem:
            self.problem = f"cannot read {self._path} ({problem}): starting without the last tare"
            return {}
        return entries if isinstance(entries, dict) else {}

    def record(self, session: int, entry: JournalEntry) -> None:
        """Remember what is in force from now on for a session of the sensor's samples.

        A full or read-only disk is noted in ``problem`` and changes nothing else.
        """
        if self._path is None:
            return
        entries = self._entries()
        entries.pop(str(session), None)
        kept = dict(list(entries.items())[1 - _ENTRIES :])
        try:
            write_whole(self._path, json.dumps({**kept, str(session): entry.to_plain()}))
            self.problem = ""
        except OSError as problem:
            text = f"cannot write {self._path} ({problem.strerror})"
            self.problem = f"{text}: a restart will have to tare again"

    def text(self, session: int | None, entry: JournalEntry) -> str:
        """The file as it would be if this entry were the only one; before a session is known, as it is."""
        if session is not None:
            return json.dumps({str(session): entry.to_plain()})
        return json.dumps(self._entries())

    def recall(self, session: int, payload: str) -> JournalEntry | None:
        """What was in force for this run of the robot process under this configuration, or None.

        Of a run that was never seen it is the payload that was in force last, without its zero; not if a file is
        configured, which says it better.
        """
        entries = self._entries()
        if str(session) in entries:
            entry = self._entry(entries[str(session)])
            return entry if entry is not None and entry.payload == payload else None
        if payload:
            return None
        found = (self._entry(plain) for plain in reversed(entries.values()))
        last = next((entry for entry in found if entry is not None and not entry.payload), None)
        return last.replaced(since=None) if last is not None and last.compensation.kind == "payload" else None

    def _entry(self, plain: Any) -> JournalEntry | None:
        if not isinstance(plain, dict):
            return None
        try:
            return JournalEntry.from_plain(plain)
        except InvalidField as problem:
            self.problem = f"{self._path} holds no compensation ({problem}): starting without the last tare"
            return None
