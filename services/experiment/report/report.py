"""Turns recordings into a folder: page, figures, claims as JSON."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from services.experiment.measure.claim import Claim, Standing, Table
from services.experiment.measure.disturbance import disturbances, late_steps, too_busy
from services.experiment.play.recording import RECORDING, Recording
from services.experiment.report.drawing import save
from services.experiment.report.page import Chapter, Page
from services.experiment.spec import Experiment
from shared import topics
from shared.schema.valid_json import valid_json

NOT_JUDGED = 4
"""Exit status where no claim fails, but some cannot be judged, since the machine was too busy."""


@dataclass(frozen=True)
class Report:
    """What was written and what it says.

    Attributes:
        index: the page.
        claims: all of them, in order.
        tables: of figures.
        problems: what may have disturbed a run, a line each.
        unfinished: runs that were not played to the end.
        busy: runs for which the machine was too busy, and by what that is seen.
    """

    index: Path
    claims: list[Claim]
    tables: list[Table]
    problems: list[str]
    unfinished: Collection[str]
    busy: dict[str, str]

    @property
    def summary(self) -> Path:
        """The file for programs: verdict, claims, tables and what was measured, as one JSON document."""
        return self.index.with_name("claims.json")

    def standing(self, claim: Claim) -> Standing:
        """Whether a claim is borne out, or cannot be judged."""
        return claim.standing(self.busy)

    def count(self, standing: Standing) -> int:
        """How many claims stand like that."""
        return sum(self.standing(claim) == standing for claim in self.claims)

    @property
    def status(self) -> int:
        """Exit status: 0 if every run was played to its end and every claim holds, 1 if not, `NOT_JUDGED`."""
        if self.count("fail") or any(name not in self.busy for name in self.unfinished):
            return 1
        return NOT_JUDGED if self.count("not judged") or self.unfinished else 0

    @property
    def verdict(self) -> str:
        """In one sentence."""
        failed, unjudged, count = self.count("fail"), self.count("not judged"), len(self.claims)
        told = [f"{name} was not played to its end" for name in self.unfinished]
        told += [f"{failed} of {count} claims fail"] if failed else []
        told += [f"{unjudged} of {count} claims not judged: the machine was too busy"] if unjudged else []
        return "; ".join(told if failed or unjudged else [*told, f"all {count} claims hold"])


def recorded(experiment: Experiment, folder: Path) -> dict[str, Recording]:
    """Recordings of the runs of an experiment, which lie in subfolders of their names.

    Raises:
        FileNotFoundError: there is none.
        ValueError: one is damaged.
    """
    recordings = {
        run.name: Recording.load(folder / run.name / RECORDING)
        for run in experiment.known
        if (folder / run.name / RECORDING).exists()
    }
    if not recordings:
        raise FileNotFoundError(f"{folder}: no recording of any run: choose {experiment.choice}")
    return recordings


def write(
    experiment: Experiment, recordings: Mapping[str, Recording], folder: Path, commands: Sequence[str] = ()
) -> Report:
    """Builds the report of runs of an experiment.

    Args:
        experiment: that was played.
        recordings: of the runs, by name.
        folder: that the page goes to, beside what the runs have left in subfolders of their names.
        commands: how they were run, for the page.

    Raises:
        ValueError: no run was played to the end.
    """
    account = experiment.account
    measured, unfinished = {}, {}
    busy = {name: seen for name, recording in recordings.items() if (seen := too_busy(recording))}
    for name, recording in recordings.items():
        try:
            measured[name] = account.measure(recording)
        except (KeyError, ValueError) as problem:
            unfinished[name] = f"{name} is not judged: {problem.args[0]}"
            if name in busy:
                unfinished[name] += f"; the machine was too busy: {busy[name]}"
    if not measured:
        raise ValueError("; ".join(unfinished.values()))
    runs = {run.name: run for run in experiment.known if run.name in measured}
    recordings = {name: recordings[name] for name in measured}
    claims, tables = account.judge(runs, measured), account.tables(measured)
    disturbed = [
        *unfinished.values(),
        *disturbances({name: found for name, found in measured.items() if name not in busy}),
    ]
    late = [
        f"{name}: the machine was too busy, so what fails in it is not judged: {seen}"
        for name, seen in busy.items()
        if name in measured
    ]
    problems = [*disturbed, *late]
    report = Report(folder / "index.html", claims, tables, problems, unfinished, busy)

    figures = folder / "figures"
    figures.mkdir(exist_ok=True)
    drawn = [(one, save(one.figure, figures / one.name)[0]) for one in account.draw(runs, recordings, measured)]
    page = Page(
        title=account.title,
        lead=account.lead,
        verdict=report.verdict,
        status=report.status,
        problems=disturbed,
        chapters=[
            Chapter(
                name=name,
                title=run.title,
                sentence=account.sentence(run, measured[name]),
                claims=_judged(report, (name,)),
                figures=[(path, one.caption) for one, path in drawn if one.run == name],
                busy=busy.get(name, ""),
            )
            for name, run in runs.items()
        ],
        compared=[(claim, report.standing(claim)) for claim in claims if len(claim.runs) > 1],
        tables=tables,
        figures=[(path, one.caption) for one, path in drawn if not one.run],
        films=[
            (folder / run.name / film, f"{run.title}: {caption}")
            for run in experiment.known
            for film, caption in account.films.items()
            if (folder / run.name / film).exists()
        ],
        facts={**_origin(recordings), **account.facts},
        files={name: [folder / name / RECORDING] for name in recordings},
        notes=account.notes(measured),
        commands=commands,
        settings={name: recording.meta["settings"] for name, recording in recordings.items()},
    )
    report.index.write_text(page.html(folder), encoding="utf-8")
    summary = {
        "verdict": report.verdict,
        "status": report.status,
        "claims": [{**dataclasses.asdict(claim), "standing": report.standing(claim)} for claim in claims],
        "tables": [dataclasses.asdict(table) for table in tables],
        "measures": {name: dataclasses.asdict(found) for name, found in measured.items()},
        "late_steps": {name: late_steps(recording) for name, recording in recordings.items()},
        "problems": problems,
    }
    report.summary.write_text(valid_json(summary, indent=2), encoding="utf-8")
    return report


def _judged(report: Report, runs: tuple[str, ...]) -> list[tuple[Claim, Standing]]:
    """The claims about just these runs, and how each stands."""
    return [(claim, report.standing(claim)) for claim in report.claims if claim.runs == runs]


def _origin(recordings: Mapping[str, Recording]) -> dict[str, str]:
    """Where and when recordings were made, and on what; what differs is told run by run."""
    return {
        "when": _told(recordings, lambda one: str(one.meta.get("date", ""))),
        "commit": _told(recordings, lambda one: one.meta.get("commit", "")),
        "machine": _told(recordings, lambda one: one.meta.get("machine", "")),
        "cores": _told(recordings, lambda one: str(one.meta.get("cores", ""))),
        "Python": _told(recordings, lambda one: one.meta.get("python", "")),
        "load average at the start": _told(recordings, lambda one: f"{one.meta.get('load_1min', '')}"),
        "duration": _told(recordings, lambda one: f"{one.time(topics.STATE_EE.key)[-1]:.0f} s"),
        "late steps, worst process": _told(recordings, _latest),
        "bus": _told(recordings, lambda one: one.meta.get("bus", "")),
    }


def _latest(recording: Recording) -> str:
    name, share = max(late_steps(recording).items(), key=lambda one: one[1], default=("", 0.0))
    return f"{100 * share:.2g} %{name and f' ({name})'}"


def _told(recordings: Mapping[str, Recording], tell: Callable[[Recording], str]) -> str:
    told = {name: tell(recording) or "not recorded" for name, recording in recordings.items()}
    if len(set(told.values())) == 1:
        return next(iter(told.values()))
    return ", ".join(f"{name} {text}" for name, text in told.items())
