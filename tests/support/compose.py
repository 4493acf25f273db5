"""The stack in containers, as `docker compose` runs it."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from tests.support.ports import free_pair
from tests.support.processes import ROOT


def unusable() -> str:
    """Why there are no containers to be had here; empty if there are."""
    if shutil.which("docker") is None or _done("docker", "info").returncode:
        return "Docker is not installed, or its engine does not run"
    return "" if _compose() else "neither docker compose nor docker-compose is installed"


def wanted() -> None:
    """Skips the test where there are no containers; with TANDEM_CONTAINERS=required, as in .ci/run, it fails."""
    if why := unusable():
        (pytest.fail if os.environ.get("TANDEM_CONTAINERS") == "required" else pytest.skip)(why)


def _compose() -> list[str]:
    """The command, the newer one first; empty if there is none."""
    for command in (["docker", "compose"], ["docker-compose"]):
        if shutil.which(command[0]) and not _done(*command, "version").returncode:
            return command
    return []


def _done(
    *command: str, timeout: float = 60.0, environment: dict[str, str] | None = None
) -> subprocess.CompletedProcess[str]:
    given = os.environ | (environment or {})
    return subprocess.run(command, cwd=ROOT, env=given, capture_output=True, text=True, timeout=timeout, check=False)


class Compose:
    """A project of its own of the compose file, built; a context manager that leaves no container and no volume.

    Args:
        project: its name.
        override: a second file, whose words come after the first one's.
        root: folder of the compose file and of what the images are built of.
        settings: in place of those in .env.

    Attributes:
        page: port of this machine on which the page is published; its picture is on the next one.
        settings: what is in force in place of .env.
    """

    def __init__(
        self,
        project: str,
        override: Path | None = None,
        root: Path = ROOT,
        settings: Mapping[str, str] | None = None,
    ) -> None:
        files = ["-f", str(root / "docker-compose.yml"), *(["-f", str(override)] if override else [])]
        self._command = [*_compose(), "-p", project, *files]
        self.project = project
        self.page = free_pair()
        self.settings = {"TANDEM_PAGE": f"{self.page}-{self.page + 1}", **(settings or {})}

    def __enter__(self) -> Compose:
        base = _done(str(ROOT / "deploy" / "base-image"), timeout=600.0)
        assert base.returncode == 0, base.stderr
        built = self.run("build", timeout=1200.0)
        assert built.returncode == 0, built.stderr + built.stdout[-2000:]
        return self

    def __exit__(self, *_: object) -> None:
        self.run("down", "--volumes", "--timeout", "2")

    def run(self, *arguments: str, timeout: float = 120.0) -> subprocess.CompletedProcess[str]:
        """What a user types after `docker compose`."""
        return _done(*self._command, *arguments, timeout=timeout, environment=self.settings)

    def do(self, *arguments: str, timeout: float = 120.0) -> str:
        """The same, which has to succeed; what it printed."""
        done = self.run(*arguments, timeout=timeout)
        assert done.returncode == 0, f"{arguments}: {done.stdout[-2000:]}{done.stderr[-2000:]}"
        return done.stdout

    def tandem(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        """The operator's command."""
        return self.run("run", "--rm", "-T", "tandem", *arguments)

    def newest(self, key: str, count: int = 1) -> list[dict[str, Any]]:
        """The next messages of a topic."""
        echoed = self.tandem("topic", "echo", key, "--count", str(count))
        assert echoed.returncode == 0, echoed.stderr
        return [json.loads(line) for line in echoed.stdout.splitlines()]

    def _container(self, service: str) -> str:
        """Asked of the engine itself: the older compose takes half a second of a core to answer."""
        labels = {"project": self.project, "service": service, "oneoff": "False"}
        filters = (f"--filter=label=com.docker.compose.{name}={value}" for name, value in labels.items())
        found = _done("docker", "ps", "-aq", *filters).stdout.split()
        assert len(found) == 1, f"{len(found)} containers of {service}"
        return found[0]

    def log(self, service: str) -> str:
        """All that a service has said so far."""
        told = _done("docker", "logs", self._container(service))
        return told.stdout + told.stderr

    def inspect(self, service: str, *path: str) -> Any:
        """What the engine knows of a service's container."""
        found: Any = json.loads(_done("docker", "inspect", self._container(service)).stdout)[0]
        for name in path:
            found = found[name]
        return found

    def health(self, service: str) -> tuple[str, str]:
        """What the engine thinks of a service: such as "healthy", and what its last check said."""
        known = self.inspect(service, "State", "Health")
        return known["Status"], known["Log"][-1]["Output"] if known["Log"] else ""
