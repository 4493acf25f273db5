"""Messages and requests of a simulation alone, see ``shared.messages``; world is ``base_footprint`` at the start."""

from __future__ import annotations

from typing import Any

import numpy as np

from shared.schema.fields import Anything, Boolean, InvalidField, Number, Quaternion, Text, Vector
from shared.schema.records import Nullable, Record, RecordOf, of


class PanelState(Record):
    """The simulated panel, in world."""

    position: np.ndarray = of(Vector("m"))
    orientation: np.ndarray = of(Quaternion())
    size: np.ndarray = of(Vector("m", "length, width, thickness; 0 if not told", minimum=0.0), default=(0.0,) * 3)


class BagState(Record):
    """The simulated bag."""

    mass: float = of(Number("kg", minimum=0.0))
    height: float = of(Number("m"))


class HandState(Record):
    """The simulated person's hands, in world; ``doing`` is the kind of phase of the script, for people to read."""

    position: np.ndarray = of(Vector("m"))
    force: np.ndarray = of(Vector("N"))
    torque: np.ndarray = of(Vector("Nm"))
    doing: str = of(Text(), default="")
    wanted: np.ndarray = of(
        Vector("m", "where the person wants them; where they are while they hold nothing"), default=(0.0,) * 3
    )
    wanted_orientation: np.ndarray = of(
        Quaternion(doc="how the person wants the panel turned; how it is while the hands hold nothing"),
        default=(0.0, 0.0, 0.0, 1.0),
    )


class SimWorld(Record):
    """Ground truth of the simulation, in world: ``base_footprint`` as it stood at the start."""

    time: float = of(Number("s", "simulated"))
    panel: PanelState | None = of(Nullable(kind=RecordOf(record=PanelState)))
    bag: BagState | None = of(Nullable(kind=RecordOf(record=BagState)))
    hand: HandState | None = of(Nullable(kind=RecordOf(record=HandState)))
    contact_force: np.ndarray = of(Vector("N"))
    marker_visible: bool = of(Boolean())


HEAVIEST = 20.0
"""Largest mass [kg] of a bag."""
LARGEST_FORCE, LARGEST_TORQUE, LONGEST_PUSH = 300.0, 50.0, 600.0
"""Largest push [N, Nm] and its longest duration [s]."""
FARTHEST = 20.0
"""Farthest target of the person's hands along each axis [m]."""
FAULT_TARGETS = ("ft", "camera", "joints")
FAULTS = ("off", "stuck", "garbage", "bias", "delay", "ok")


class Reset(Record):
    """Set the whole scene back to its start: `state/*` and `sensor/camera` begin a new session."""


class Load(Record):
    """Hang a bag of this total mass from the tool; 0 takes it off."""

    mass: float = of(Number("kg", minimum=0.0, maximum=HEAVIEST))


class Push(Record):
    """Push at the tool for a while."""

    duration: float = of(Number("s", minimum=0.0, maximum=LONGEST_PUSH))
    force: np.ndarray = of(Vector("N", minimum=-LARGEST_FORCE, maximum=LARGEST_FORCE), default=(0.0,) * 3)
    torque: np.ndarray = of(Vector("Nm", minimum=-LARGEST_TORQUE, maximum=LARGEST_TORQUE), default=(0.0,) * 3)


class Hand(Record):
    """Let the simulated person act out a script, or lead the person's hands to a target: one of both."""

    script: str | None = of(Nullable(doc="name, or TOML text", kind=Text(longest=64 * 1024)), default=None)
    target: np.ndarray | None = of(
        Nullable("m", "in world", kind=Vector("m", minimum=-FARTHEST, maximum=FARTHEST)), default=None
    )

    def check(self) -> None:
        if (self.script is None) == (self.target is None):
            raise InvalidField("hand takes either script, a name or TOML text, or target, 3 numbers in m")


class CoverMarker(Record):
    """Lay something over the marker, or take it away."""

    covered: bool = of(Boolean(), default=True)


class SensorFault(Record):
    """Break a sensor's line, or mend it."""

    target: str = of(Text(choices=FAULT_TARGETS))
    kind: str = of(Text(choices=FAULTS))
    value: Any = of(
        Anything("", "of a bias: N, Nm, rad or of 255, one number or one per axis; of a delay: s"), default=None
    )
