"""The report's index page: one HTML file that needs nothing but the folder it lies in."""

from __future__ import annotations

import base64
import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jinja2

from services.experiment.measure.claim import Claim, Table

_MEDIA = {".svg": "image/svg+xml", ".png": "image/png"}


@dataclass(frozen=True)
class Page:
    """What stands on the page.

    Attributes:
        title, lead: of the page.
        claims: all of them; those of one run together.
        tables: under the claims; rows of one name stand together, and their second column names them.
        figures: SVG or PNG files with captions; they are embedded.
        films: what stands at the top, with captions; a picture is embedded, a film linked.
        facts: about all runs.
        files: of each run, which are linked.
        notes: how to read it.
        commands: how it was run.
        settings: run -> service -> parameter -> value; the services' defaults hold for the rest.
    """

    title: str
    lead: str
    claims: Sequence[Claim]
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
