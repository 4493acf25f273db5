"""The load experiment: how it is played, and the account that is given of it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from services.experiment.load import load_protocol as protocol
from services.experiment.load.load_claims import LEAST_WAY, judge
from services.experiment.load.load_course import LoadSequence
from services.experiment.load.load_measures import Measures, measure
from services.experiment.measure.brakes import SETTLING
from services.experiment.play.course import Run
from services.experiment.play.recording import Recording
from services.experiment.spec import Account, Drawn, Experiment
from services.viewer.take import Part
from shared import topics
from shared.messages import ControlTarget
from shared.spatial import quaternion_from_rpy

_HANGS = {
    "light": (f"{protocol.LIGHT:g} N hang from the tool", f"under {protocol.LIGHT:g} N"),
    "heavy": (f"{protocol.HEAVY:g} N hang from it, more than its limit", f"under {protocol.HEAVY:g} N"),
    "unload": ("the bag is taken off", "taken off"),
}
"""Caption in the film, and name of the still of its end."""


def parts(recording: Recording) -> list[Part]:
    """What hangs from the tool, and since when."""
    loads = [event for event in recording.events if event.name in _HANGS]
    ends = [*(event.time for event in loads[1:]), float(recording.time(topics.STATE_EE.key)[-1])]
    return [Part(event.name, event.time, end, *_HANGS[event.name]) for event, end in zip(loads, ends, strict=True)]


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
        "The same after the heavier bag: how each law lowers it and how it lands. Unsmoothed. "
        "Dot: the bag touches the ground.",
    )
    frame = figures.Frame.of(recordings.values())
    for name, run in runs.items():
        caption = f"{run.title}: every sample (pale) and the mean over 0.3 s."
        if measured[name].brakes:
            caption += " Grey: a brake on the way down, and the time for which it upsets the load."
        yield Drawn(name, figures.draw_run(run, recordings[name], measured[name], frame), caption, name)


def sentence(run: Run, found: Measures) -> str:
    """What became of a run, in one sentence that goes on after its title."""
    if run.law == "stiffness":
        return f"sags by {1e3 * found.sag:.0f} mm under {protocol.LIGHT:g} N, the baseline that the paper starts from."
    held = f"holds {protocol.LIGHT:g} N within {1e3 * found.hold_error:.1f} mm"
    if not math.isfinite(found.landing):
        return f"{held}, and does not bring {protocol.HEAVY:g} N to the ground."
    return (
        f"{held}, lowers {protocol.HEAVY:g} N to the ground in {found.lowering_time:.1f} s, the load swinging by "
        f"±{found.load_swing:.1f} N, and bears {found.ground_peak:.1f} N there at most; the limit is "
        f"{protocol.FORCE_LIMIT[2]:g} N."
    )


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
    beside=protocol.BESIDE,
    course=LoadSequence,
    parts=parts,
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
        films={
            "strip.png": "the ends of its parts",
            "scene.mp4": "what was recorded; on the left, if it was played, the paper's law",
        },
        measure=measure,
        sentence=sentence,
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
