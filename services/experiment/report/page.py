"""The report's index page: one HTML file that needs nothing but the folder it lies in."""

from __future__ import annotations

import base64
import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jinja2

from services.experiment.measure.claim import Claim, Standing, Table

_MEDIA = {".svg": "image/svg+xml", ".png": "image/png"}


@dataclass(frozen=True)
class Chapter:
    """One run.

    Attributes:
        name, title: of it.
        sentence: what became of it; goes on after the title.
        claims: about it alone, and how each stands.
        figures: of it.
        busy: by what it is seen that the machine was too busy; empty if it was not.
    """

    name: str
    title: str
    sentence: str
    claims: Sequence[tuple[Claim, Standing]]
    figures: Sequence[tuple[Path, str]]
    busy: str

    @property
    def standing(self) -> Standing:
        """Of all claims about it: the worst."""
        found = {standing for _, standing in self.claims}
        return "fail" if "fail" in found else "not judged" if "not judged" in found else "pass"

    @property
    def verdict(self) -> str:
        """How its claims stand, in words."""
        count = len(self.claims)
        wrong = sum(standing == self.standing for _, standing in self.claims)
        words = {"pass": f"all {count} claims hold", "fail": f"{wrong} of {count} claims fail"}
        return words.get(self.standing, f"{wrong} of {count} claims not judged")


@dataclass(frozen=True)
class Page:
    """What stands on the page, told as a story: the verdict, a sentence per run, pictures, the comparison, the runs.

    Attributes:
        title, lead: of the page.
        verdict: in one sentence.
        status: exit status that goes with it.
        problems: what may have disturbed a run, a line each, but for what a chapter tells.
        chapters: a run each.
        compared: claims about two runs, and how each stands.
        tables: below them; rows of one name stand together, and their second column names them.
        figures: of all runs: SVG or PNG files with captions; they are embedded, like those of a run.
        films: the first pictures, with captions; a picture is embedded, a film linked.
        facts: about all runs.
        files: of each run, which are linked.
        notes: how to read it.
        commands: how it was run.
        settings: run -> service -> parameter -> value; the services' defaults hold for the rest.
    """

    title: str
    lead: str
    verdict: str
    status: int
    problems: Sequence[str]
    chapters: Sequence[Chapter]
    compared: Sequence[tuple[Claim, Standing]]
    tables: Sequence[Table]
    figures: Sequence[tuple[Path, str]]
    films: Sequence[tuple[Path, str]]
    facts: Mapping[str, str]
    files: Mapping[str, Sequence[Path]]
    notes: Sequence[str]
    commands: Sequence[str]
    settings: Mapping[str, Mapping[str, Mapping[str, Any]]]

    def html(self, folder: Path) -> str:
        """The whole page, with links relative to the folder."""
        environment = jinja2.Environment(
            loader=jinja2.FileSystemLoader(Path(__file__).parent),
            autoescape=True,
            undefined=jinja2.StrictUndefined,
            trim_blocks=True,
            lstrip_blocks=True,
        )
        environment.filters.update(embedded=_embedded, short=_short)
        environment.tests["picture"] = lambda path: path.suffix in _MEDIA
        environment.globals["link"] = lambda path: path.relative_to(folder).as_posix()
        content = {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}
        parameters = dict.fromkeys(
            (service, name)
            for services in self.settings.values()
            for service, values in services.items()
            for name in values
        )
        return environment.get_template("page.html.j2").render(content, parameters=parameters)


def _embedded(path: Path) -> str:
    """A picture as a URL that holds it."""
    return f"data:{_MEDIA[path.suffix]};base64,{base64.b64encode(path.read_bytes()).decode()}"


def _short(value: Any) -> str:
    if isinstance(value, (list, tuple)) and len(set(value)) == 1:
        return f"{value[0]} (each of {len(value)})"
    return str(value)
