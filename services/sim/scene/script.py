"""What a simulated person is going to do, as data: a TOML text with one table ``[[phase]]`` after the other."""

from __future__ import annotations

import math
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from shared.parameters import Refused

BUILT_IN = {"carry": Path(__file__).parent / "scripts" / "carry.toml"}
LONGEST = 64 * 1024
"""Characters of a script; it comes in one message."""
MOST_PHASES = 100


@dataclass(frozen=True)
class Phase:
    """One thing that the person does.

    Attributes:
        do: "wait" (until the robot has gripped the panel, or let go of it), "take_hold", "lift", "move", "turn",
            "lower" or "let_go".
        until: of "wait": "grasp" or "release".
        by: of "move": metres forwards (away from the robot, along the panel), to the left, and up.
        height: of "lift" [m].
        about: of "turn": the panel's own long axis "x", or the vertical "z".
        angle: of "turn" [rad].
        speed: [m/s] of moving, [rad/s] of turning; the average over a movement that begins and ends gently.
        patience: time [s] after which the person goes on to the next phase all the same.
        pause: time [s] that the person stands still afterwards.
    """

    do: str
    until: str = "grasp"
    by: tuple[float, float, float] = (0.0, 0.0, 0.0)
    height: float = 0.0
    about: str = "x"
    angle: float = 0.0
    speed: float = 0.1
    patience: float = 20.0
    pause: float = 1.0


_NUMBERS = {
    "height": (0.0, 1.0, "m"),
    "angle": (-180.0, 180.0, "degrees"),
    "speed": (0.01, 1.0, "m/s or rad/s"),
    "patience": (0.0, 600.0, "s"),
    "pause": (0.0, 60.0, "s"),
}
_WORDS = {"until": ("grasp", "release"), "about": ("x", "z")}
_FIELDS = {
    "wait": ("until",),
    "take_hold": (),
    "lift": ("height", "speed"),
    "move": ("by", "speed"),
    "turn": ("about", "angle", "speed"),
    "lower": ("speed",),
    "let_go": (),
}
"""What each kind of phase takes, besides patience and pause."""
_FARTHEST = 5.0


def read(script: str) -> tuple[Phase, ...]:
    """The phases of a built-in script's name or of a TOML text.

    Raises:
        Refused: with one line that says which phase, what was given and what is allowed.
    """
    if script in BUILT_IN:
        script = BUILT_IN[script].read_text(encoding="utf-8")
    if len(script) > LONGEST:
        raise Refused(f"script has {len(script)} characters, allowed are {LONGEST}")
    try:
        content = tomllib.loads(script)
    except (tomllib.TOMLDecodeError, RecursionError) as problem:
        names = ", ".join(map(repr, BUILT_IN))
        raise Refused(f"script is neither {names} nor TOML ({' '.join(str(problem).split())})") from None
    phases = content.get("phase")
    if set(content) != {"phase"} or not isinstance(phases, list) or not 0 < len(phases) <= MOST_PHASES:
        raise Refused(
            f"script holds {sorted(content)}, wanted 1 to {MOST_PHASES} tables [[phase]] and nothing else"
        )
    return tuple(_phase(number, table) for number, table in enumerate(phases, 1))


def _phase(number: int, table: Any) -> Phase:
    where = f"script, phase {number}"
    if not isinstance(table, dict):
        raise Refused(f"{where} is {table!r}, wanted a table")
    do = table.get("do")
    if not isinstance(do, str) or do not in _FIELDS:
        raise Refused(f"{where}: do is {do!r}, allowed are {', '.join(_FIELDS)}")
    allowed = (*_FIELDS[do], "patience", "pause")
    unknown = next((name for name in table if name not in ("do", *allowed)), None)
    if unknown is not None:
        raise Refused(f"{where}: {unknown} is nothing that {do} has; it has {', '.join(allowed)}")
    values = {name: _value(where, name, given) for name, given in table.items() if name != "do"}
    missing = next((name for name in _FIELDS[do] if name not in values and name != "speed"), None)
    if missing is not None:
        raise Refused(f"{where}: {missing} is missing; {do} needs it")
    return Phase(do, **values)


def _value(where: str, name: str, given: Any) -> Any:
    if name in _WORDS:
        if given not in _WORDS[name]:
            raise Refused(f"{where}: {name} is {given!r}, allowed are {', '.join(_WORDS[name])}")
        return given
    if name == "by":
        if not isinstance(given, list) or len(given) != 3:
            raise Refused(f"{where}: by is {given!r}, wanted 3 numbers")
        return tuple(_number(f"{where}: by", value, -_FARTHEST, _FARTHEST, "m") for value in given)
    low, high, unit = _NUMBERS[name]
    number = _number(f"{where}: {name}", given, low, high, unit)
    return math.radians(number) if name == "angle" else number


def _number(what: str, given: Any, low: float, high: float, unit: str) -> float:
    if isinstance(given, bool) or not isinstance(given, (int, float)) or not low <= given <= high:
        raise Refused(f"{what} is {given!r}, allowed is a number from {low:g} to {high:g} {unit}")
    return float(given)
