"""The carry, ready to be played."""

from __future__ import annotations

from services.experiment.carry import carry_film as film
from services.experiment.carry import carry_protocol as protocol
from services.experiment.carry import carry_report as report
from services.experiment.carry.carry_course import CarrySequence
from services.experiment.spec import Play

CARRY = Play(
    name="carry",
    runs=protocol.RUNS,
    run_named=protocol.run_named,
    duration=protocol.EXPECTED,
    filmed=protocol.FILMED,
    course=CarrySequence,
    report=report.write,
    film_data=film.film_data,
    meta={"force_limit": list(protocol.FORCE_LIMIT), "torque_limit": list(protocol.TORQUE_LIMIT)},
)
