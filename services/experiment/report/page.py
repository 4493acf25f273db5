"""The report's index page: one HTML file that needs nothing but the folder it lies in."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

from services.experiment.measure.claim import Claim
from services.experiment.report.table import Table

_STYLE = """
:root { color-scheme: light; --ink: #1c1c1c; --soft: #5c5c5c; --line: #dcdcdc; --good: #00694d; --bad: #b00020; }
body { font: 16px/1.55 system-ui, "DejaVu Sans", sans-serif; color: var(--ink); background: #fff; margin: 0; }
main { max-width: 66rem; margin: 0 auto; padding: 2.5rem 1.5rem 4rem; }
h1 { font-size: 1.9rem; line-height: 1.2; margin: 0 0 .3rem; }
h2 { font-size: 1.2rem; margin: 2.6rem 0 .6rem; }
p, li { max-width: 46rem; }
.lead { color: var(--soft); margin-top: 0; }
.verdict { font-weight: 600; padding: .7rem 1rem; border-left: 4px solid; background: #f7f7f7; }
.verdict.pass { border-color: var(--good); } .verdict.fail { border-color: var(--bad); }
table { border-collapse: collapse; width: 100%; font-size: .9rem; }
th, td { text-align: left; padding: .38rem .7rem .38rem 0; border-bottom: 1px solid var(--line); vertical-align: top; }
th { font-weight: 600; } td.run { font-weight: 600; white-space: nowrap; }
td.number { font-variant-numeric: tabular-nums; width: 24%; } td.claim { width: 42%; }
.mark { font-weight: 700; white-space: nowrap; } .pass .mark { color: var(--good); } .fail .mark { color: var(--bad); }
.figures td, .figures th { text-align: right; padding: .25rem 0 .25rem .9rem; font-variant-numeric: tabular-nums; }
.figures td:first-child, .figures th:first-child { text-align: left; padding-left: 0; }
.grouped td:nth-child(2), .grouped th:nth-child(2) { text-align: left; }
.figures th { vertical-align: bottom; } .figures td { white-space: nowrap; }
tr.first td { border-top: 2px solid #9a9a9a; }
figure { margin: 1.2rem 0 2rem; } figure img, video { width: 100%; height: auto; }
figcaption { color: var(--soft); font-size: .9rem; max-width: 46rem; }
pre, code { font: .85rem/1.5 "DejaVu Sans Mono", monospace; }
pre { background: #f7f7f7; padding: .8rem 1rem; overflow-x: auto; }
.wide { overflow-x: auto; }
"""

_MEDIA = {".svg": "image/svg+xml", ".png": "image/png"}


def page(
    title: str,
    lead: str,
    claims: Sequence[Claim],
    figures: Sequence[tuple[Path, str]],
    films: Mapping[str, Path],
    facts: Mapping[str, str],
    files: Mapping[str, Sequence[Path]],
    folder: Path,
    notes: Sequence[str],
    commands: Sequence[str],
    settings: Mapping[str, Mapping[str, Mapping[str, Any]]],
    tables: Sequence[Table] = (),
) -> str:
    """The whole page. Pictures (SVG or PNG files), stills among the films too, are embedded; films and CSV files are
    linked relative to `folder`; tables stand under the claims.
    """
    failed = sum(not claim.passed for claim in claims)
    verdict = (
        f"{len(claims)} of {len(claims)} claims hold."
        if not failed
        else f"{failed} of {len(claims)} claims fail."
    )
    parts = [
        f"<h1>{escape(title)}</h1>",
        f'<p class="lead">{escape(lead)}</p>',
        f'<p class="verdict {"fail" if failed else "pass"}">{verdict}</p>',
    ]
    if films:
        # First of all, so that everything below is understood.
        parts.append("<h2>What happened</h2>")
        parts += [
            _figure(path, caption) if path.suffix in _MEDIA else _video(path.relative_to(folder), caption)
            for caption, path in films.items()
        ]
    parts += ["<h2>Claims</h2>", _claims(claims)]
    for table in tables:
        parts += [f"<h2>{escape(table.title)}</h2>", _table(table)]
    parts += ["<h2>Figures</h2>", *(_figure(path, caption) for path, caption in figures)]
    parts += ["<h2>How to read it</h2>", "<ul>", *(f"<li>{escape(note)}</li>" for note in notes), "</ul>"]
    parts += [
        "<h2>How it was run</h2>",
        f"<pre>{escape(chr(10).join(commands))}</pre>",
        _facts(facts),
        _settings(settings),
    ]
    parts += [
        "<h2>Data</h2>",
        "<p>Every series of every run as CSV; times in seconds from the start of the protocol.</p>",
    ]
    parts.append(_files(files, folder))
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escape(title)}</title><style>{_STYLE}</style></head>\n<body><main>\n"
        + "\n".join(parts)
        + "\n</main></body></html>\n"
    )


def _claims(claims: Sequence[Claim]) -> str:
    rows, last = [], None
    for claim in claims:
        state, mark = ("pass", "✓ pass") if claim.passed else ("fail", "✗ fail")
        first = claim.run != last
        rows.append(
            f'<tr class="{state}{" first" if first else ""}"><td class="run">{escape(claim.run) if first else ""}</td>'
            f'<td class="claim">{escape(claim.text)}</td><td class="number">{escape(claim.figure)}</td>'
            f'<td class="number">{escape(claim.limit)}</td><td class="mark">{mark}</td></tr>'
        )
        last = claim.run
    head = "<tr><th>run</th><th>claim</th><th>measured</th><th>required</th><th></th></tr>"
    return f'<div class="wide"><table>{head}{"".join(rows)}</table></div>'


def _table(table: Table) -> str:
    """Rows of one name stand together, named once, and their second column names them."""
    rows, last = [], None
    grouped = len({name for name, *_ in table.rows}) < len(table.rows)
    for name, *cells in table.rows:
        first = name != last
        rows.append(
            f'<tr{" class=first" if first and grouped else ""}><td class="run">{escape(name) if first else ""}</td>'
            + "".join(f"<td>{escape(cell)}</td>" for cell in cells)
            + "</tr>"
        )
        last = name
    head = "".join(f"<th>{escape(name)}</th>" for name in table.head)
    kind = "figures grouped" if grouped else "figures"
    return f'<div class="wide"><table class="{kind}"><tr>{head}</tr>{"".join(rows)}</table></div>'


def _figure(path: Path, caption: str) -> str:
    data = base64.b64encode(path.read_bytes()).decode()
    return (
        f'<figure><img alt="{escape(caption)}" src="data:{_MEDIA[path.suffix]};base64,{data}">'
        f"<figcaption>{escape(caption)}</figcaption></figure>"
    )


def _video(path: Path, caption: str) -> str:
    return (
        f'<figure><video controls preload="metadata" src="{path.as_posix()}"></video>'
        f"<figcaption>{escape(caption)}</figcaption></figure>"
    )


def _facts(facts: Mapping[str, str]) -> str:
    rows = "".join(
        f"<tr><td>{escape(name)}</td><td>{escape(value)}</td></tr>" for name, value in facts.items()
    )
    return f"<table>{rows}</table>"


def _settings(settings: Mapping[str, Mapping[str, Mapping[str, Any]]]) -> str:
    """Run by run, every parameter that was set; the services' defaults hold for the rest."""
    names = dict.fromkeys(
        f"{service}.{name}" for run in settings.values() for service, table in run.items() for name in table
    )
    head = "<tr><th>parameter</th>" + "".join(f"<th>{escape(run)}</th>" for run in settings) + "</tr>"
    rows = []
    for name in names:
        service, parameter = name.split(".", 1)
        values = [run.get(service, {}).get(parameter, "default") for run in settings.values()]
        rows.append(
            f"<tr><td>{escape(name)}</td>"
            + "".join(f"<td>{escape(_short(value))}</td>" for value in values)
            + "</tr>"
        )
    return f'<div class="wide"><table>{head}{"".join(rows)}</table></div>'


def _short(value: Any) -> str:
    if isinstance(value, (list, tuple)) and len(set(value)) == 1:
        return f"{value[0]} (each of {len(value)})"
    return str(value)


def _files(files: Mapping[str, Sequence[Path]], folder: Path) -> str:
    rows = []
    for run, paths in files.items():
        links = " · ".join(
            f'<a href="{path.relative_to(folder).as_posix()}">{escape(path.name)}</a>' for path in paths
        )
        rows.append(f'<tr><td class="run">{escape(run)}</td><td>{links}</td></tr>')
    return f"<table>{''.join(rows)}</table>"
