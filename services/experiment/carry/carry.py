"""The carry as an experiment: how it is played, and the account that is given of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from services.experiment.carry import carry_protocol as protocol
from services.experiment.carry.carry_claims import judge
from services.experiment.carry.carry_course import CarrySequence
from services.experiment.carry.carry_measures import Measures, measure
from services.experiment.carry.carry_parts import recorded_parts
from services.experiment.carry.carry_tables import notes, sentence, tables
from services.experiment.play.course import Run
from services.experiment.play.recording import Recording
from services.experiment.spec import Account, Drawn, Experiment


def _draw(
    runs: Mapping[str, Run], recordings: Mapping[str, Recording], measured: Mapping[str, Measures]
) -> Iterator[Drawn]:
    # What draws takes its time to be imported.
    from services.experiment.carry import carry_figures as figures

    walked = {
        name: run for name, run in runs.items() if protocol.SCRIPTS[name.rpartition("-")[2]] == protocol.SCRIPTS["omni"]
    }
    if len(walked) > 1:
        yield Drawn(
            "comparison",
            figures.draw_comparison(walked, recordings, measured),
            "The laws with the same script. From above: the largest share of a limit on any axis (the largest "
            "within 0.3 s), the force of the person's hands, and the person's work while guiding the robot, "
            f"without half of the panel's weight. The parts named are those of {next(iter(walked))}.",
        )
    frame = figures.Frame.of(recordings, measured)
    for name, run in runs.items():
        for kind, draw, caption in (
            (
                "wrench",
                figures.draw_wrench,
                f"force and torque at the tool, base axes, every sample up to {figures.CUT_OFF:g} limits. Dashed: "
                "limits, centred on the agreed share of the weight; red: over a limit.",
            ),
            (
                "paths",
                figures.draw_paths,
                "base, tool and hands from above, and the panel at some moments. Dots: at the grasp; squares: at the "
                "release; circles: the base.",
            ),
            (
                "heights",
                figures.draw_heights,
                "heights of the panel's ends, and how it is turned. Line: the gripper opens.",
            ),
        ):
            figure = draw(run, recordings[name], measured[name], frame)
            yield Drawn(f"{name}-{kind}", figure, f"{run.title}: {caption}", name)


_LENGTH, _WIDTH, _ = protocol.PANEL_SIZE
CARRY = Experiment(
    name="carry",
    runs=protocol.RUNS,
    known=(
        *protocol.RUNS,
        *(
            one
            for law in protocol.LAWS
            for base in protocol.BASES
            if (one := protocol.run(law, base)) not in protocol.RUNS
        ),
    ),
    choice=f"LAW-BASE with a law of {', '.join(protocol.LAWS)} and a base of {', '.join(protocol.BASES)}",
    duration=protocol.EXPECTED,
    filmed=protocol.FILMED,
    beside=protocol.BESIDE,
    course=CarrySequence,
    parts=recorded_parts,
    account=Account(
        title="The carry",
        lead=f"The simulated TIAGo finds a panel of {_LENGTH:g} m by {_WIDTH:g} m and {protocol.PANEL_MASS:g} kg, "
        "grasps it, and carries it together with a simulated person, who guides the robot with it, turns it upright "
        "and sets it down.",
        facts={
            "panel": f"{' x '.join(f'{size:g}' for size in protocol.PANEL_SIZE)} m, {protocol.PANEL_MASS:g} kg",
            "force limits": f"{', '.join(f'{limit:g}' for limit in protocol.FORCE_LIMIT)} N along x, y, z",
            "torque limits": f"{', '.join(f'{limit:g}' for limit in protocol.TORQUE_LIMIT)} Nm about x, y, z",
        },
        films={
            "strip.png": "moments of the carry",
            "scene.mp4": "what was recorded; on the left, if it was played, the paper's law",
        },
        measure=measure,
        sentence=sentence,
        judge=judge,
        notes=notes,
        draw=_draw,
        tables=tables,
    ),
    meta={"force_limit": list(protocol.FORCE_LIMIT), "torque_limit": list(protocol.TORQUE_LIMIT)},
)
