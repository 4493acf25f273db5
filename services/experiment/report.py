"""What a report says in short, and what all reports share; each experiment writes its own."""

from __future__ import annotations

import dataclasses
import json
import platform
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from services.experiment.claim import Claim
from services.experiment.recording import Recording

Found = TypeVar("Found")


@dataclass(frozen=True)
class Report:
    """What was written and what it says.

    Attributes:
        index: the page.
        claims: all of them, in order.
        problems: what may have disturbed a run, a line each.
        unfinished: runs that are not judged, and why.
    """

    index: Path
    claims: list[Claim]
    problems: list[str]
    unfinished: list[str]


def measure_all(
    recordings: Mapping[str, Recording], measure: Callable[[Recording], Found]
) -> tuple[dict[str, Found], list[str]]:
    """The figures of the runs that were played to the end, and a line for each other one.

    Raises:
        ValueError: no run was.
    """
    measured, unfinished = {}, []
    for name, recording in recordings.items():
        try:
            measured[name] = measure(recording)
        except (KeyError, ValueError) as problem:
            unfinished.append(f"{name} is not judged: {problem.args[0]}")
    if not measured:
        raise ValueError("; ".join(unfinished))
    return measured, unfinished


def conclude(
    folder: Path,
    text: str,
    claims: list[Claim],
    measured: Mapping[str, Any],
    problems: list[str],
    unfinished: list[str],
) -> Report:
    """Writes the page and `claims.json`; `measured` are the figures of each run, dataclasses."""
    index = folder / "index.html"
    index.write_text(text, encoding="utf-8")
    summary = {
        "claims": [dataclasses.asdict(claim) for claim in claims],
        "measures": {name: dataclasses.asdict(found) for name, found in measured.items()},
        "problems": problems,
    }
    (folder / "claims.json").write_text(json.dumps(summary, indent=2), encoding="utf-8")
    return Report(index, claims, problems, unfinished)


def origin(recordings: Mapping[str, Recording]) -> dict[str, str]:
    """Where and when recordings were made, for the page."""
    first = next(iter(recordings.values()))
    version = ".".join(str(part) for part in sys.version_info[:3])
    return {
        "when": str(first.meta.get("date", "")),
        "machine": f"{platform.machine()}, {platform.system()}, Python {version}",
        "bus": str(first.meta.get("bus", "")),
    }
