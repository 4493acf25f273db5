"""What outlives the process: the file of an identified payload, and the journal of the present compensation.

The journal makes a restarted process continue where the killed one stopped: with a bag on the tool nobody could tare.
An entry belongs to one run of the robot process, named by the session of its samples, and is never used for another.
"""

from __future__ import annotations

import json
import math
import tomllib
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from services.wrench.compensation import Compensation
from services.wrench.identification import IdentifiedPayload
from shared.loop.files import write_whole
from shared.parameters import Refused

_ENTRIES = 8


def save_payload(path: Path, result: IdentifiedPayload) -> None:
    """Write an identified payload as TOML.

    Raises:
        Refused: if the file cannot be written.
    """
    lines = ["# Weight beyond the force-torque sensor and the sensor's bias: SI units, sensor axes."]
    for item in fields(result):
        value = getattr(result, item.name)
        lines.append(f"{item.name} = {value.tolist() if isinstance(value, np.ndarray) else value}")
    try:
        write_whole(path, "\n".join(lines) + "\n")
    except OSError as problem:
        raise Refused(f"cannot write the payload to {path}: {problem.strerror}") from None


def load_payload(path: Path) -> IdentifiedPayload:
    """Read what ``save_payload`` wrote.

    Raises:
        Refused: if there is no such file or it holds something else; one line.
    """
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as problem:
        raise Refused(f"payload {path}: {problem.strerror}; `tandem identify` makes such a file") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as problem:
        raise Refused(f"payload {path}: not TOML ({problem})") from None
    sizes = {"residual_rms": 6, "residual_peak": 6, "noise": 6}
    scalars = ("mass", "sigma_mass", "condition", "poses")
    values: dict[str, Any] = {}
    for item in fields(IdentifiedPayload):
        if item.name not in content:
            raise Refused(
                f"payload {path}: {item.name} is missing; make the file anew with `tandem identify`"
            )
        size = 0 if item.name in scalars else sizes.get(item.name, 3)
        values[item.name] = _numbers(path, item.name, content[item.name], size)
    if values["mass"] <= 0.0:
        raise Refused(f"payload {path}: mass is {values['mass']} kg, wanted more than 0 kg")
    return IdentifiedPayload(**values)


def _numbers(path: Path, name: str, value: Any, size: int) -> Any:
    numbers = value if isinstance(value, list) else [value]
    good = all(
        isinstance(number, (int, float)) and not isinstance(number, bool) and math.isfinite(number)
        for number in numbers
    )
    negative = name.startswith(("sigma", "residual", "noise")) and good and min(numbers, default=0) < 0
    if not good or negative or len(numbers) != (size or 1) or isinstance(value, list) != (size > 0):
        kind = f"{size} numbers" if size else "a number"
        raise Refused(
            f"payload {path}: {name} is {value!r}, wanted {kind}{', not negative' if negative else ''}"
        )
    return np.array(numbers, dtype=float) if size else value


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
        except (OSError, ValueError) as problem:
            self.problem = f"cannot read {self._path} ({problem}): starting without the last tare"
            return {}
        return entries if isinstance(entries, dict) else {}

    def record(self, session: int, payload: str, compensation: Compensation) -> None:
        """Remember a compensation; a full or read-only disk is noted in ``problem`` and changes nothing else.

        Args:
            session: of the sensor's samples.
            payload: value of the parameter of that name.
            compensation: in force from now on.
        """
        if self._path is None:
            return
        plain = {
            item.name: value.tolist() if isinstance(value, np.ndarray) else value
            for item in fields(compensation)
            for value in (getattr(compensation, item.name),)
        }
        entries = self._entries()
        entries.pop(str(session), None)
        kept = dict(list(entries.items())[1 - _ENTRIES :])
        try:
            write_whole(
                self._path, json.dumps({**kept, str(session): {"payload": payload, "compensation": plain}})
            )
            self.problem = ""
        except OSError as problem:
            self.problem = (
                f"cannot write {self._path} ({problem.strerror}): a restart will have to tare again"
            )

    def recall(self, session: int, payload: str) -> Compensation | None:
        """What was in force for this run of the robot process under this configuration, or None."""
        entry = self._entries().get(str(session))
        if not isinstance(entry, dict) or entry.get("payload") != payload:
            return None
        try:
            plain = entry["compensation"]
            arrays: dict[str, Any] = {
                name: np.array(value, dtype=float) if isinstance(value, list) else value
                for name, value in plain.items()
            }
            recalled = Compensation(**arrays)
            blank = Compensation()
            for item in fields(blank):
                if np.shape(getattr(recalled, item.name)) != np.shape(getattr(blank, item.name)):
                    raise ValueError(item.name)
        except (KeyError, TypeError, ValueError, AttributeError) as problem:
            self.problem = f"{self._path} holds no compensation ({problem}): starting without the last tare"
            return None
        return recalled
