"""What a simulated person is going to do, as data: a TOML text with one table ``[[phase]]`` after the other."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from shared.parameters import Refused
from shared.schema.fields import InvalidField, Number, Text, Vector, shown
from shared.schema.records import Record, of
from shared.spatial import Array

BUILT_IN = {"carry": Path(__file__).parent / "scripts" / "carry.toml"}
LONGEST = 64 * 1024
"""Characters of a script; it comes in one message."""
MOST_PHASES = 100


class Phase(Record):
    """One thing that the person does: "wait" until the robot has gripped the panel, or let go of it, and so on."""

    do: str = of(Text(choices=("wait", "take_hold", "lift", "move", "turn", "lower", "let_go")))
    until: str = of(Text(choices=("grasp", "release")), default="grasp")
    by: Array = of(
        Vector("m", "forwards (away from the robot, along the panel), to the left, and up", minimum=-5.0, maximum=5.0),
        default=(0.0,) * 3,
    )
    height: float = of(Number("m", minimum=0.0, maximum=1.0), default=0.0)
    about: str = of(Text(doc="the panel's own long axis x, or the vertical z", choices=("x", "z")), default="x")
    angle: float = of(Number("degrees", minimum=-180.0, maximum=180.0), default=0.0)
    speed: float = of(
        Number("m/s or rad/s", "on average; begins and ends gently", minimum=0.01, maximum=1.0), default=0.1
    )
    patience: float = of(Number("s", "until the next phase all the same", minimum=0.0, maximum=600.0), default=20.0)
    pause: float = of(Number("s", "standing still afterwards", minimum=0.0, maximum=60.0), default=1.0)


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
        raise Refused(f"script holds {sorted(content)}, wanted 1 to {MOST_PHASES} tables [[phase]] and nothing else")
    return tuple(_phase(number, table) for number, table in enumerate(phases, 1))


def _phase(number: int, table: Any) -> Phase:
    where = f"script, phase {number}"
    if not isinstance(table, dict):
        raise Refused(f"{where} is {table!r}, wanted a table")
    try:
        needed = _FIELDS.get(str(table.get("do")), ())
        allowed = (*needed, "patience", "pause")
        unknown = next((name for name in table if name not in ("do", *allowed)), None)
        phase = Phase.from_plain({name: table[name] for name in ("do", *allowed) if name in table}, f"{where}: ")
    except InvalidField as problem:
        raise Refused(str(problem)) from None
    if unknown is not None:
        raise Refused(f"{where}: {shown(unknown)} is nothing that {phase.do} has; it has {', '.join(allowed)}")
    missing = next((name for name in needed if name not in table and name != "speed"), None)
    if missing is not None:
        raise Refused(f"{where}: {missing} is missing; {phase.do} needs it")
    return phase
