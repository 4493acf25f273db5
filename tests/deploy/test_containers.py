"""The stack in containers: it comes up and moves, and what is stopped, killed or hung comes back.

Skipped by name where there are no containers; with TANDEM_CONTAINERS=required, as in .ci/run, it fails instead.
"""

from __future__ import annotations

import os
import re
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml

from shared.processes import PROCESSES, ROUTER
from tests.support import compose
from tests.support.compose import Compose
from tests.support.wait import eventually

pytestmark = [pytest.mark.processes, pytest.mark.slow, pytest.mark.timeout(1500)]

BY_ITSELF = [process.name for process in PROCESSES if process.started != "by hand"]
PATIENCE = 60.0  # [s]
SOMEBODY = 12345
"""Owner of the folder of reports, if the tests may choose one."""


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("runs")
    for place in (folder, *folder.parents[:2]):
        place.chmod(0o755)
    if os.getuid() == 0:
        os.chown(folder, SOMEBODY, SOMEBODY)
    return folder


@pytest.fixture(scope="module")
def stack(runs: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Compose]:
    if why := compose.unusable():
        (pytest.fail if os.environ.get("TANDEM_CONTAINERS") == "required" else pytest.skip)(why)
    override = tmp_path_factory.mktemp("compose") / "runs.yml"
    override.write_text(yaml.safe_dump({"services": {"experiment": {"volumes": [f"{runs}:/opt/tandem/runs"]}}}))
    with Compose("tandem-test", override) as stack:
        stack.do("up", "-d")
        yield stack


def log(stack: Compose, service: str) -> str:
    return stack.do("logs", "--no-color", service)


def state(stack: Compose) -> str:
    return stack.newest("task/status")["state"]


def test_the_carry_begins_by_itself(stack: Compose) -> None:
    eventually(lambda: "approaching" in log(stack, "experiment"), PATIENCE, lambda: log(stack, "experiment"))


def test_everybody_says_that_it_works(stack: Compose) -> None:
    stack.healthy(*BY_ITSELF)
    shown = stack.tandem("status").stdout
    # A busy machine makes some degraded afterwards: they are alive all the same.
    alive = [name for name in BY_ITSELF if re.search(rf"^{name} +(ok|degraded)", shown, re.MULTILINE)]
    assert alive == [name for name in BY_ITSELF if name != ROUTER.name], shown


def test_a_controller_that_was_stopped_is_waited_for(stack: Compose) -> None:
    began = time.monotonic()
    stack.do("stop", "controller")
    assert time.monotonic() - began < 5.0, "it ends within two seconds"
    assert stack.inspect("controller", "State", "ExitCode") == 0
    assert stack.newest("state/robot")["mode"] == "holding"
    assert "waiting" in stack.newest("task/status")["reason"]
    stack.do("start", "controller")
    eventually(lambda: stack.newest("state/robot")["mode"] == "ready", PATIENCE, "it goes on")
    assert state(stack) != "holding"


def test_a_task_that_was_killed_carries_on(stack: Compose) -> None:
    eventually(lambda: state(stack) == "carrying", PATIENCE, lambda: log(stack, "experiment"))
    stack.do("kill", "task")
    stack.do("start", "task")
    eventually(lambda: state(stack) in ("carrying", "releasing"), PATIENCE, "it goes by its journal")


def test_a_hung_router_stops_the_arm_and_the_log_says_why(stack: Compose) -> None:
    stack.do("kill", "-s", "STOP", "router")
    eventually(lambda: "silent" in log(stack, "controller"), PATIENCE, "its reason")
    stack.do("kill", "-s", "CONT", "router")
    eventually(lambda: stack.newest("state/robot")["mode"] == "ready", PATIENCE, "it goes on")


def test_a_process_that_dies_is_restarted(stack: Compose) -> None:
    stack.run("exec", "-T", "base", "python", "-c", "import os; os.kill(1, 15)")
    eventually(lambda: stack.inspect("base", "RestartCount") == 1, PATIENCE, "the engine restarts it")


def test_another_experiment_is_played_and_its_report_is_its_reader_s(stack: Compose, runs: Path) -> None:
    stack.do("stop", "experiment")
    done = stack.run("run", "--rm", "-T", "experiment", "load", "--no-film", timeout=300.0)
    assert "claims" in done.stdout, done.stdout + done.stderr
    (page,) = runs.glob("load-*/index.html")
    assert page.stat().st_uid == runs.stat().st_uid
    stack.do("stop", "sim", "wrench", "base", "router")
