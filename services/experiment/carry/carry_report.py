"""Turns recordings of the carry into a folder: page, figures, CSV of every series, film, claims as JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from services.experiment.carry import carry_figures as figures
from services.experiment.carry.carry_claims import judge
from services.experiment.carry.carry_measures import Measures, measure
from services.experiment.carry.carry_protocol import (
    BASES,
    FORCE_LIMIT,
    LAWS,
    PANEL_MASS,
    PANEL_SIZE,
    RUNS,
    SCRIPTS,
    TORQUE_LIMIT,
    run_named,
)
from services.experiment.carry.notes import notes
from services.experiment.carry.tables import tables
from services.experiment.measure.disturbance import disturbances
from services.experiment.play.recording import Recording
from services.experiment.report.drawing import save
from services.experiment.report.film import FILM, STRIP
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
    played = measure_all(folder, _known(), f"LAW-BASE (as in {RUNS[0].name})", measure)
    runs, recordings, measured = played.runs, played.recordings, played.figures
    claims, compared = judge(runs, measured), tables(measured)
    problems = [*played.unfinished, *disturbances(measured)]

    drawn = _draw(folder, runs, recordings, measured)
    files = {name: recording.write_csv(folder / name / "csv") for name, recording in recordings.items()}
    length, width, _ = PANEL_SIZE
    text = page(
        "The carry",
        f"The simulated TIAGo finds a panel of {length:g} m by {width:g} m and {PANEL_MASS:g} kg, grasps it, and "
        "carries it together with a simulated person, who guides the robot with it, turns it upright and sets it "
        "down.",
        claims,
        drawn,
        _scenes(folder, runs),
        {
            **origin(recordings),
            "panel": f"{' x '.join(f'{size:g}' for size in PANEL_SIZE)} m, {PANEL_MASS:g} kg",
            "force limits": f"{', '.join(f'{limit:g}' for limit in FORCE_LIMIT)} N along x, y, z",
            "torque limits": f"{', '.join(f'{limit:g}' for limit in TORQUE_LIMIT)} Nm about x, y, z",
        },
        files,
        folder,
        [*problems, *notes(measured)],
        commands,
        {name: recording.meta["settings"] for name, recording in recordings.items()},
        compared,
    )
    return conclude(folder, text, claims, measured, problems, played.unfinished, compared)


def _scenes(folder: Path, runs: Mapping[str, Run]) -> dict[str, Path]:
    """Strip and film of every run of which there are any, by their captions."""
    scenes = {}
    for name, run in runs.items():
        scenes[f"{run.title}: moments of the carry; below, what the head's camera sees"] = (
            folder / name / STRIP
        )
        scenes[f"{run.title}: what was recorded of robot, panel and person, rendered"] = folder / name / FILM
    return {caption: path for caption, path in scenes.items() if path.exists()}


def _known() -> list[Run]:
    """Every run that there is, those that are played by default first."""
    names = [f"{law}-{base}" for law in LAWS for base in BASES]
    return [*RUNS, *(run_named(name) for name in names if name not in {run.name for run in RUNS})]


def _draw(
    folder: Path,
    runs: Mapping[str, Run],
    recordings: Mapping[str, Recording],
    measured: Mapping[str, Measures],
) -> list[tuple[Path, str]]:
    target = folder / "figures"
    target.mkdir(exist_ok=True)
    drawn = []
    walked = {name: run for name, run in runs.items() if SCRIPTS[name.rpartition("-")[2]] == SCRIPTS["omni"]}
    if len(walked) > 1:
        figure = figures.draw_comparison(walked, recordings, measured)
        drawn.append(
            (
                save(figure, target / "comparison")[0],
                "The laws with the same script. From above: the largest share of a limit on any axis (the largest "
                "within 0.3 s), the force of the person's hands, and the person's work while guiding the robot, "
                f"without half of the panel's weight. The parts named are those of {next(iter(walked))}.",
            )
        )
    for name, run in runs.items():
        for kind, draw, caption in (
            ("wrench", figures.draw_wrench, "force and torque at the tool, in base axes, every sample."),
            ("paths", figures.draw_paths, "base, tool and hands from above, and the panel at some moments."),
            ("heights", figures.draw_heights, "heights of the panel's ends, and how it is turned."),
        ):
            figure = draw(run, recordings[name], measured[name])
            drawn.append((save(figure, target / f"{name}-{kind}")[0], f"{run.title}: {caption}"))
    return drawn
