"""The messages that only a simulation publishes, see ``shared.messages``; world is ``base_footprint`` at the start."""

from __future__ import annotations

import numpy as np

from shared.schema.fields import Boolean, Number, Quaternion, Text, Vector
from shared.schema.records import Record, RecordOf, of


class PanelState(Record):
    """The simulated panel, in world."""

    position: np.ndarray = of(Vector("m"))
    orientation: np.ndarray = of(Quaternion())


class BagState(Record):
    """The simulated bag."""

    mass: float = of(Number("kg", minimum=0.0))
    height: float = of(Number("m"))


class HandState(Record):
    """The simulated person's hands, in world; ``doing`` is the kind of phase of his script, for people to read."""

    position: np.ndarray = of(Vector("m"))
    force: np.ndarray = of(Vector("N"))
    torque: np.ndarray = of(Vector("Nm"))
    doing: str = of(Text(), default="")
    wanted: np.ndarray = of(
        Vector("m", "where he wants them; where they are while they hold nothing"), default=(0.0,) * 3
    )
    wanted_orientation: np.ndarray = of(
        Quaternion(doc="how he wants the panel turned; how it is while he holds nothing"),
        default=(0.0, 0.0, 0.0, 1.0),
    )


class SimWorld(Record):
    """Ground truth of the simulation, in world: ``base_footprint`` as it stood at the start."""

    time: float = of(Number("s", "simulated"))
    panel: PanelState | None = of(RecordOf(record=PanelState, nullable=True))
    bag: BagState | None = of(RecordOf(record=BagState, nullable=True))
    hand: HandState | None = of(RecordOf(record=HandState, nullable=True))
    contact_force: np.ndarray = of(Vector("N"))
    marker_visible: bool = of(Boolean())
