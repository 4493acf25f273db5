"""Turns recordings of the load experiment into a folder: page, figures, CSV of every series, film, claims as JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from services.experiment.load import load_figures as figures
from services.experiment.load.load_claims import LEAST_WAY, judge
from services.experiment.load.load_measures import Measures, measure
from services.experiment.load.load_protocol import (
    FORCE_LIMIT,
    HEAVY,
    HOLD,
    LIGHT,
    RUNS,
    TORQUE_LIMIT,
    unambiguous,
)
from services.experiment.measure.brakes import SETTLING
from services.experiment.measure.disturbance import disturbances
from services.experiment.play.recording import Recording
from services.experiment.report.drawing import save
from services.experiment.report.film import FILM
from services.experiment.report.page import page
from services.experiment.report.summary import Report, conclude, measure_all, origin
from services.experiment.run import Run


def write(folder: Path, commands: Sequence[str] = ()) -> Report:
    """Builds the report of all runs recorded under `folder` (one subfolder per run with its recording).

    Args:
        folder: where the runs lie and the page goes.
        commands: how it was run, for the page.

    Raises:
        FileNotFoundError: no recording under `folder`.
        ValueError: no run was played to the end.
    """
    names = f"({', '.join(run.name for run in RUNS)})"
    played = measure_all(folder, RUNS, names, measure)
    runs, recordings, measured = played.runs, played.recordings, played.figures
    claims = judge(runs, measured, FORCE_LIMIT[2])
    problems = [*played.unfinished, *disturbances(measured)]

    drawn = _draw(folder, runs, recordings, measured)
    files = {name: recording.write_csv(folder / name / "csv") for name, recording in recordings.items()}
    films = {name: folder / name / FILM for name in runs if (folder / name / FILM).exists()}
    text = page(
        "Load experiment",
        f"The simulated TIAGo holds a pose with force limits of {FORCE_LIMIT[2]:.0f} N. A bag of {LIGHT:.0f} N "
        f"is hung from its tool, then made heavier than the limit ({HEAVY:.0f} N), then taken off.",
        claims,
        drawn,
        {f"{runs[name].title}: the recorded joint angles, rendered": path for name, path in films.items()},
        _facts(recordings),
        files,
        folder,
        [*problems, *_notes(measured)],
        commands,
        {name: recording.meta["settings"] for name, recording in recordings.items()},
    )
    return conclude(folder, text, claims, measured, problems, played.unfinished)


def _draw(
    folder: Path,
    runs: Mapping[str, Run],
    recordings: Mapping[str, Recording],
    measured: Mapping[str, Measures],
) -> list[tuple[Path, str]]:
    target = folder / "figures"
    target.mkdir(exist_ok=True)
    drawn = [
        (
            save(figures.draw_comparison(runs, recordings), target / "comparison")[0],
            "All laws in the same test: load on the tool (mean over 0.3 s, pale: its range) and height of the tool.",
        ),
        (
            save(figures.draw_lowering(runs, recordings, measured), target / "lowering")[0],
            "The same after the heavier bag: how each law lowers it and how it lands. Unsmoothed.",
        ),
    ]
    for name, run in runs.items():
        figure = figures.draw_run(run, recordings[name], measured[name])
        caption = f"{run.title}: every sample (pale) and the mean over 0.3 s." + (
            " Grey: a brake on the way down, and the time for which it upsets the load."
            if measured[name].brakes
            else ""
        )
        drawn.append((save(figure, target / name)[0], caption))
    return drawn


def _notes(measured: Mapping[str, Measures]) -> list[str]:
    bound = max(found.error_bound for found in measured.values())
    return [
        f"The paper's heavier bag weighs exactly the limit, so noise decides. Here it weighs {HEAVY:.0f} N, more than "
        f"the limit plus twice the error bound that the wrench service publishes ({bound:.2f} N) plus a margin "
        f"({unambiguous(bound):.2f} N in all).",
        "A weight that hangs free cannot be made lighter by moving: while it hangs, the load exceeds the limit by "
        "definition. What the laws promise is to lower it, and the certified law that the load is back within the "
        "limit once the ground bears the rest.",
        "A brake stops the tool at once when a sample or a command is late; it has to, and the load swings after it. "
        f"Whether the load is steady is judged outside of brakes and {SETTLING:g} s after each, on "
        f"{100 * LEAST_WAY:.0f} % of the way at least; their number and reasons stand beside the figure.",
        "The stiffness law is the paper's baseline at the paper's stiffness; that it sags is the finding, not a fault.",
    ]


def _facts(recordings: Mapping[str, Recording]) -> dict[str, str]:
    return {
        **origin(recordings),
        "hold pose": f"[{', '.join(f'{value:g}' for value in HOLD)}] (m, rad)",
        "limits": f"{FORCE_LIMIT[0]:g} N, {TORQUE_LIMIT[0]:g} Nm on every axis",
        "bags": f"{LIGHT:g} N, then {HEAVY:g} N",
    }
