"""The stack in containers: it comes up and moves, and what is stopped, killed or hung comes back.

Skipped by name where there are no containers; with TANDEM_CONTAINERS=required, as in .ci/run, it fails instead.
"""

from __future__ import annotations

import os
import re
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
    with Compose(f"tandem-test-{os.getpid()}", override) as stack:
        stack.do("up", "-d")
        yield stack


def log(stack: Compose, service: str) -> str:
    return stack.do("logs", "--no-color", service)


def moves(stack: Compose) -> bool:
    """Whether the robot may move now and then; what a busy machine has latched is released."""
    stack.tandem("resume")
    return any(said["mode"] == "ready" for said in stack.newest("state/robot", 200))


def test_the_carry_begins_by_itself(stack: Compose) -> None:
    eventually(lambda: "approaching" in log(stack, "experiment"), PATIENCE, lambda: log(stack, "experiment"))


def test_another_experiment_is_played_and_its_report_is_its_reader_s(stack: Compose, runs: Path) -> None:
    stack.do("stop", "experiment")
    assert stack.inspect("experiment", "State", "ExitCode") == 0, "it gives the controller back what it had"
    done = stack.run("run", "--rm", "-T", "experiment", "load", "--no-film", timeout=300.0)
    assert "claims" in done.stdout, done.stdout + done.stderr
    (page,) = runs.glob("load-*/index.html")
    assert page.stat().st_uid == runs.stat().st_uid


def test_a_controller_that_was_stopped_is_waited_for(stack: Compose) -> None:
    # The experiment's target is still in force.
    eventually(lambda: moves(stack), PATIENCE)
    stack.do("stop", "controller")
    assert stack.inspect("controller", "State", "ExitCode") == 0, "it ended by itself, within two seconds"
    assert {said["mode"] for said in stack.newest("state/robot", 20)} == {"holding"}
    stack.do("start", "controller")
    assert stack.run("run", "-d", "--rm", "tandem", "hold", "0.5", "-0.3", "1", "0", "0", "0").returncode == 0
    eventually(lambda: moves(stack), PATIENCE, "it goes on")


def test_a_hung_router_stops_the_arm_and_the_log_says_why(stack: Compose) -> None:
    told = log(stack, "controller").count("allowed are")
    stack.do("kill", "-s", "STOP", "router")
    eventually(lambda: log(stack, "controller").count("allowed are") > told, PATIENCE, "its reason")
    stack.do("kill", "-s", "CONT", "router")
    eventually(lambda: moves(stack), PATIENCE, "it goes on")


def test_what_was_tared_outlives_a_killed_process_but_not_the_robot(stack: Compose) -> None:
    def known() -> str:
        return stack.newest("wrench/external")[0]["compensation"]

    before = known()
    assert before != "none"
    stack.do("kill", "wrench")
    stack.do("start", "wrench")
    eventually(lambda: known() == before, PATIENCE, "it goes by its journal")
    elapsed = stack.newest("sim/world")[0]["time"]
    stack.do("stop", "sim")

    def hungry() -> bool:
        status, why = stack.health("wrench")
        return status == "unhealthy" and "sensor/ft is" in why

    eventually(hungry, PATIENCE, lambda: str(stack.health("wrench")))
    stack.do("start", "sim")
    eventually(lambda: stack.newest("sim/world")[0]["time"] < elapsed, PATIENCE, "a new robot")
    eventually(lambda: stack.health("wrench")[0] == "healthy", PATIENCE, lambda: str(stack.health("wrench")))


def test_a_process_that_dies_is_restarted_and_everybody_works(stack: Compose) -> None:
    stack.run("exec", "-T", "base", "python", "-c", "import os; os.kill(1, 15)")
    eventually(lambda: stack.inspect("base", "RestartCount") == 1, PATIENCE, "the engine restarts it")

    def alive() -> set[str]:
        """Who says how it is; a busy machine makes some degraded."""
        return set(re.findall(r"^(\w+) +(?:ok|degraded)", stack.tandem("status").stdout, re.MULTILINE))

    eventually(lambda: alive() >= {*BY_ITSELF} - {ROUTER.name}, PATIENCE, lambda: stack.tandem("status").stdout)


def test_everybody_ends_by_itself_within_two_seconds(stack: Compose) -> None:
    stack.do("stop")
    assert {name: stack.inspect(name, "State", "ExitCode") for name in BY_ITSELF} == dict.fromkeys(BY_ITSELF, 0)
