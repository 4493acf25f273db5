"""The runs of an experiment, as `services.experiment` states them: services never import each other."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

from services.cli.refusal import refuse
from services.cli.stack.children import command
from services.cli.stack.plan import to_toml


def planned(experiment: str, names: list[str]) -> dict[str, Any]:
    """The runs of these names, all that are usual if there are none, with how long each takes and which is filmed.

    Refuses a name that there is not.
    """
    arguments = ["plan", experiment, *(word for name in names for word in ("--run", name))]
    done = subprocess.run(command("experiment", arguments), capture_output=True, text=True, check=False)
    # A signal that ends both finds it without a word, too.
    if done.returncode or not done.stdout:
        said = (done.stderr.strip().splitlines() or ["ended without a word"])[-1]
        refuse(said.removeprefix("experiment: "), done.returncode or 1)
    return json.loads(done.stdout)


def write_config(run: dict[str, Any], path: Path) -> Path:
    """A run's settings as a file for `tandem up --config`."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(to_toml(run["settings"]), encoding="utf-8")
    return path
