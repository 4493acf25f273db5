"""What is installed: packages of the extras in pyproject.toml, as the installed metadata tells them."""

from __future__ import annotations

import re
from collections.abc import Collection
from importlib.metadata import PackageNotFoundError, distribution, requires

from services.cli.common import refuse
from shared.processes import process_named

_REQUIREMENT = re.compile(r"(?P<package>[A-Za-z0-9._-]+).*extra == ['\"](?P<extra>[a-z0-9-]+)['\"]")


def lacking(extra: str) -> list[str]:
    """Packages of an extra that are not installed; none where it is not told what the extra needs."""
    try:
        rows = [match for row in requires("tandem") or () if (match := _REQUIREMENT.match(row))]
    except PackageNotFoundError:
        return []
    wanted = extra.replace("_", "-")  # as metadata spell it
    return [row["package"] for row in rows if row["extra"] == wanted and not _installed(row["package"])]


def need(processes: Collection[str]) -> None:
    """Refuses with one line if processes that are to be started lack a package."""
    extras = sorted({process_named(name).extra for name in processes} - {""})
    missing = {extra: packages for extra in extras if (packages := lacking(extra))}
    if missing:
        named = ", ".join(dict.fromkeys(package for found in missing.values() for package in found))
        refuse(f"{named} not installed: pip install '.[{','.join(missing)}]' in its checkout")


def _installed(package: str) -> bool:
    try:
        distribution(package)
    except PackageNotFoundError:
        return False
    return True
