"""Requests and replies of the queries in ``shared.topics``; ``ok`` and a refusal's ``error`` are the framework's.

And what a service tells of those that it takes up, which nobody else on the bus hears.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from shared.schema.fields import Anything, Boolean, Bytes, Integer, Number, Text, TextList, Vector
from shared.schema.records import MapOf, Nullable, Record, RecordOf, of

SHORTEST_AVERAGE, LONGEST_AVERAGE = 0.1, 30.0
"""Duration [s] of one measurement."""
_FORCE = Boolean(doc="adopt it although it is implausible; `warning` then says what is")
_WARNING = Text(doc="what is implausible about what was adopted by force, else empty")
_DURATION = Number("s", "of the average", minimum=SHORTEST_AVERAGE, maximum=LONGEST_AVERAGE)


class Nothing(Record):
    """No field at all."""


class Tare(Record):
    """Average the sensor while the tool is still, and subtract that from now on. Refused while moving or unhealthy."""

    duration: float = of(_DURATION, default=1.0)
    force: bool = of(_FORCE, default=False)


class Tared(Record):
    """The bias that is subtracted, sensor axes."""

    force: np.ndarray = of(Vector("N"))
    torque: np.ndarray = of(Vector("Nm", "about the sensor's origin"))
    samples: int = of(Integer(minimum=0))
    std: np.ndarray = of(Vector("N, Nm", "standard deviation of one reading", size=6))
    replaced_age: float = of(Number("s", "age of the zero that this one replaces, -1 without one"), default=-1.0)
    warning: str = of(_WARNING, default="")


class StartIdentification(Record):
    """Begin with no poses."""


class AddPose(Record):
    """Average the sensor in one more pose."""

    duration: float = of(_DURATION, default=1.0)


class SolveIdentification(Record):
    """Find the payload, and subtract it from now on. Refused when the poses do not excite it."""

    force: bool = of(_FORCE, default=False)


class CancelIdentification(Record):
    """Forget the poses."""


class Poses(Record):
    """How many poses were added."""

    poses: int = of(Integer(minimum=0))


class PoseAdded(Record):
    """How many poses were added, and what the last one was like."""

    poses: int = of(Integer(minimum=0))
    samples: int = of(Integer(minimum=0))
    std: np.ndarray = of(Vector("N, Nm", "standard deviation of one reading", size=6))


class Solved(Record):
    """The payload beyond the sensor and the sensor's bias, sensor axes."""

    mass: float = of(Number("kg"))
    com: np.ndarray = of(Vector("m", "centre of mass from the sensor's origin"))
    force_bias: np.ndarray = of(Vector("N"))
    torque_bias: np.ndarray = of(Vector("Nm"))
    sigma: np.ndarray = of(Vector("kg, m, N, Nm", "standard deviations: mass, com, force_bias, torque_bias", size=None))
    residual_rms: np.ndarray = of(Vector("N, Nm", size=6))
    condition: float = of(Number("1", "of the poses"))
    poses: int = of(Integer(minimum=0))
    file: str = of(Text(doc="where it was written, empty if nowhere"))
    warning: str = of(_WARNING, default="")


TASK_WORDS = ("start", "abort", "release", "reset")


class TaskCommand(Record):
    """Command of a person to the task."""

    command: str = of(Text(choices=TASK_WORDS))


class TaskAnswer(Record):
    """Where the task is now."""

    state: str = of(Text())


class ParameterRequest(Record):
    """Change what is named in ``set``, all or nothing; without it only the table is asked for."""

    set: dict[str, Any] | None = of(Nullable(kind=MapOf(doc="name -> value")), default=None)


class ParameterRow(Record):
    """One parameter; a range holds for each element of a vector, and is open where it is null."""

    value: Any = of(Anything())
    unit: str = of(Text())
    min: float | None = of(Nullable(kind=Number()))
    max: float | None = of(Nullable(kind=Number()))
    doc: str = of(Text())


class ParameterTable(Record):
    """All parameters by their names, as they are in force."""

    parameters: dict[str, ParameterRow] = of(MapOf(kind=RecordOf(record=ParameterRow)))


class Setup(Record):
    """What a service works by, told at its start, every second and with each request: what a replay goes by."""

    parameters: dict[str, Any] = of(MapOf(doc="name -> value, as they are in force"))
    chosen: tuple[str, ...] = of(TextList(doc="names of those that are not just defaults"))
    files: dict[str, str] = of(MapOf(doc="name -> content: what a new start would find", kind=Text(longest=16384)))
    query: str = of(Text(doc="key of the request that was taken up just now, empty if none was"))
    request: bytes = of(Bytes(doc="as it arrived; empty if it was too large to be looked at"))
    inputs: tuple[str, ...] = of(TextList(doc="keys that are subscribed to, or were"))
    diary: bytes = of(Bytes(doc="arrivals and turns of the loop since the last one of these: `shared/loop/diary.py`"))
