"""The load experiment: how it is played, and the account that is given of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from services.experiment.load import load_protocol as protocol
from services.experiment.load.load_claims import LEAST_WAY, judge
from services.experiment.load.load_course import LoadSequence
from services.experiment.load.load_measures import Measures, measure
from services.experiment.measure.brakes import SETTLING
from services.experiment.play.course import Run
from services.experiment.play.recording import Recording
from services.experiment.spec import Account, Drawn, Experiment
from shared import topics
from shared.messages import ControlTarget
from shared.spatial import quaternion_from_rpy


def film_data(recording: Recording) -> dict[str, Any]:
    """What `services/sim/film/load_film.py` reads: joint angles, bag and load on the joints' time base.

    Raises:
        KeyError: the recording lacks what the film shows.
    """
    joints, world, wrench = topics.STATE_JOINTS.key, topics.SIM_WORLD.key, topics.WRENCH_EXTERNAL.key
    time = recording.time(joints)
    shown = time >= 0
    time = time[shown]
    return {
        "scene": "load",
        "time": time,
        "joint_names": recording.series(joints, "name")[0],
        "joint_positions": recording.series(joints, "position")[shown],
        "bag_mass": np.nan_to_num(recording.newest(world, time, "bag.mass")),
        "bag_height": recording.newest(world, time, "bag.height"),
        "force_z": np.interp(time, recording.time(wrench), recording.series(wrench, "force")[:, 2]),
        "limit_z": np.full(len(time), recording.meta["force_limit"][2]),
    }


def _draw(
    runs: Mapping[str, Run], recordings: Mapping[str, Recording], measured: Mapping[str, Measures]
) -> Iterator[Drawn]:
    # What draws takes its time to be imported.
    from services.experiment.load import load_figures as figures

    yield Drawn(
        "comparison",
        figures.draw_comparison(runs, recordings),
        "All laws in the same test: load on the tool (mean over 0.3 s, pale: its range) and height of the tool.",
    )
    yield Drawn(
        "lowering",
        figures.draw_lowering(runs, recordings, measured),
        "The same after the heavier bag: how each law lowers it and how it lands. Unsmoothed.",
    )
    for name, run in runs.items():
        caption = f"{run.title}: every sample (pale) and the mean over 0.3 s."
        if measured[name].brakes:
            caption += " Grey: a brake on the way down, and the time for which it upsets the load."
        yield Drawn(name, figures.draw_run(run, recordings[name], measured[name]), caption)


def _notes(measured: Mapping[str, Measures]) -> list[str]:
    bound = max(found.error_bound for found in measured.values())
    return [
        f"The paper's heavier bag weighs exactly the limit, so noise decides. Here it weighs {protocol.HEAVY:.0f} N, "
        f"more than the limit plus twice the error bound that the wrench service publishes ({bound:.2f} N) plus a "
        f"margin ({protocol.unambiguous(bound):.2f} N in all).",
        "A weight that hangs free cannot be made lighter by moving: while it hangs, the load exceeds the limit by "
        "definition. What the laws promise is to lower it, and the certified law that the load is back within the "
        "limit once the ground bears the rest.",
        "A brake stops the tool at once when a sample or a command is late; it has to, and the load swings after it. "
        f"Whether the load is steady is judged outside of brakes and {SETTLING:g} s after each, on "
        f"{100 * LEAST_WAY:.0f} % of the way at least; their number and reasons stand beside the figure.",
        "The stiffness law is the paper's baseline at the paper's stiffness; that it sags is the finding, not a fault.",
    ]


LOAD = Experiment(
    name="load",
    runs=protocol.RUNS,
    known=protocol.RUNS,
    choice=f"from {', '.join(run.name for run in protocol.RUNS)}",
    duration=protocol.END_AT,
    filmed=protocol.FILMED,
    course=LoadSequence,
    film_data=film_data,
    account=Account(
        title="Load experiment",
        lead=f"The simulated TIAGo holds a pose with force limits of {protocol.FORCE_LIMIT[2]:.0f} N. A bag of "
        f"{protocol.LIGHT:.0f} N is hung from its tool, then made heavier than the limit ({protocol.HEAVY:.0f} N), "
        "then taken off.",
        facts={
            "hold pose": f"[{', '.join(f'{value:g}' for value in protocol.HOLD)}] (m, rad)",
            "limits": f"{protocol.FORCE_LIMIT[0]:g} N, {protocol.TORQUE_LIMIT[0]:g} Nm on every axis",
            "bags": f"{protocol.LIGHT:g} N, then {protocol.HEAVY:g} N",
        },
        films={"scene.mp4": "the recorded joint angles, rendered"},
        measure=measure,
        judge=judge,
        notes=_notes,
        draw=_draw,
    ),
    target=ControlTarget(
        position=np.array(protocol.HOLD[:3]),
        orientation=quaternion_from_rpy(*protocol.HOLD[3:]),
        force_limit=np.array(protocol.FORCE_LIMIT),
        torque_limit=np.array(protocol.TORQUE_LIMIT),
    ),
    meta={"force_limit": list(protocol.FORCE_LIMIT), "torque_limit": list(protocol.TORQUE_LIMIT)},
)
