"""The load experiment, ready to be played."""

from __future__ import annotations

import numpy as np

from services.experiment.load import load_film as film
from services.experiment.load import load_protocol as protocol
from services.experiment.load import load_report as report
from services.experiment.load.load_course import LoadSequence
from services.experiment.spec import Play
from shared.messages import ControlTarget
from shared.spatial import quaternion_from_rpy

LOAD = Play(
    name="load",
    runs=protocol.RUNS,
    run_named=protocol.run_named,
    duration=protocol.END_AT,
    filmed=protocol.FILMED,
    course=LoadSequence,
    report=report.write,
    film_data=film.film_data,
    target=ControlTarget(
        position=np.array(protocol.HOLD[:3]),
        orientation=quaternion_from_rpy(*protocol.HOLD[3:]),
        force_limit=np.array(protocol.FORCE_LIMIT),
        torque_limit=np.array(protocol.TORQUE_LIMIT),
    ),
    meta={"force_limit": list(protocol.FORCE_LIMIT), "torque_limit": list(protocol.TORQUE_LIMIT)},
)
