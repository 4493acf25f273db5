"""`tandem top`: a row for each process of a robot, with what it tells and what /proc tells."""

from __future__ import annotations

import json
import signal

import pytest

from services.cli.health.diagnose import Heard
from services.cli.health.usage import Usage
from services.cli.top import row, shown
from shared.messages import Health
from tests.conftest import Router, StartProcess
from tests.services.cli.command import tandem_here
from tests.services.cli.test_listing import shown as printed
from tests.support.wait import eventually

HEALTH = Health("ok", "", 100.0, 410.0, 950.0, 7, {})


def test_a_row_has_what_is_known_and_null_for_the_rest() -> None:
    here = row("wrench", Usage(12, 4.25, 75.12), Heard(HEALTH, 0.3))
    assert here["cpu_percent"] == 4.2 and here["memory_MB"] == 75.1 and here["late_steps"] == 7
    elsewhere, mute = row("wrench", None, Heard(HEALTH, 0.3)), row("router", Usage(1, 0.0, 70.0), None)
    assert elsewhere["pid"] is None and elsewhere["loop_p99_us"] == 950.0
    assert mute["state"] is None and mute["loop_hz"] is None


def test_the_table_fits_into_a_usual_terminal_and_says_who_is_silent() -> None:
    late, fine = row("controller", Usage(1234567, 104.2, 1075.0), Heard(HEALTH, 1.4)), row("task", None, None)
    lines = printed(shown([late, fine]), 80)
    assert len(lines) <= 4 and max(map(len, lines)) <= 80
    assert lines[-2].split() == ["controller", "1234567", "104", "1075", "silent", "1.4", "100", "7", "410", "950"]


@pytest.mark.processes
def test_it_shows_a_running_robot_and_ends_with_ctrl_c(
    router: Router, start: StartProcess, capsys: pytest.CaptureFixture[str]
) -> None:
    place = ("--connect", router.endpoint)
    nobody = tandem_here(capsys, "top", "--robot", "nobody", "--connect", router.endpoint, "--json")
    assert [one["process"] for one in json.loads(nobody.stdout)["processes"]] == ["router"]
    start("services.mock", *place)

    def told() -> dict[str, dict[str, object]]:
        done = tandem_here(capsys, "top", "--json", *place)
        return {one["process"]: one for one in json.loads(done.stdout)["processes"]}

    eventually(lambda: told().get("mock", {}).get("state") == "ok", 60.0, "its health is shown")
    assert told()["mock"]["memory_MB"] > 1.0
    once = tandem_here(capsys, "top", "--once", *place)
    assert once.returncode == 0 and "mock" in once.stdout and {"late", "steps"} <= set(once.stdout.split())
    going = start("services.cli", "top", *place, environment={"FORCE_COLOR": "1", "TERM": "xterm"})
    going.wait_for_output("mock")
    going.signal(signal.SIGINT)
    assert going.wait() == 0, going.output
