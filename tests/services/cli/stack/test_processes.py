"""`tandem up` and the commands that speak to it, as real processes over a real router."""

from __future__ import annotations

import json
import os
import re
import signal
import urllib.request
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from shared.processes import STACK
from tests.services.cli.command import exists, pids, tandem
from tests.support.ports import free_endpoint
from tests.support.processes import Process
from tests.support.wait import eventually

pytestmark = [pytest.mark.processes, pytest.mark.slow, pytest.mark.timeout(300)]
PATIENCE = 60.0  # [s]
ALL = (*STACK, "base")


@pytest.fixture(scope="module")
def endpoint() -> str:
    return free_endpoint()


@pytest.fixture(scope="module")
def stack(endpoint: str, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Process]:
    output = tmp_path_factory.mktemp("up") / "output"
    with Process("services.cli", ["up", "--with", "base", "--connect", endpoint], output) as process:
        # A busy machine makes the simulation degraded: it is alive all the same.
        alive = [re.compile(rf" {name}: (ok|degraded)") for name in ALL]
        eventually(
            lambda: not process.running or all(pattern.search(process.output) for pattern in alive),
            PATIENCE,
            "every service is alive",
        )
        assert process.running, process.output
        yield process


def test_status_finds_everything_alive(stack: Process, endpoint: str) -> None:
    done = tandem("status", "--connect", endpoint)
    assert all(re.search(rf"^{name} +(ok|degraded)", done.stdout, re.MULTILINE) for name in ALL), done.stdout


def test_the_page_is_named_and_shows_this_robot(stack: Process, endpoint: str) -> None:
    found = re.search(r"see it at (http://127\.0\.0\.1:\d+/)", stack.output)
    assert found, stack.output

    def robot() -> str:
        with suppress(OSError), urllib.request.urlopen(f"{found[1]}state") as answer:
            return str(json.load(answer)["robot"])
        return ""

    eventually(lambda: robot() == "tiago", PATIENCE, lambda: stack.output)


def test_hz_shows_the_rates(stack: Process, endpoint: str) -> None:
    done = tandem("topic", "hz", "--connect", endpoint)
    rates = dict(re.findall(r"^(\S+/\S+) +([\d.]+)", done.stdout, re.MULTILINE))
    assert {"sensor/ft", "wrench/external", "state/ee", "control/status", "health/controller"} <= rates.keys()
    assert float(rates["sensor/ft"]) > 10.0


def test_echo_prints_messages(stack: Process, endpoint: str) -> None:
    done = tandem("topic", "echo", "wrench/external", "--count", "2", "--connect", endpoint)
    assert done.returncode == 0
    assert done.stdout.count('"error_bound"') == 2


def test_parameters_are_read_set_and_refused(stack: Process, endpoint: str) -> None:
    assert tandem("param", "get", "controller.law", "--connect", endpoint).stdout == "certified\n"
    done = tandem("param", "set", "controller.max_linear=0.2", "--connect", endpoint)
    assert done.stdout == "controller.max_linear = 0.2\n"
    refused = tandem("param", "set", "controller.max_linear=99", "--connect", endpoint)
    assert refused.returncode == 1
    assert "max_linear is 99" in refused.stderr
    assert tandem("param", "get", "controller.max_linear", "--connect", endpoint).stdout == "0.2\n"


def test_the_base_is_part_of_the_stack_if_asked_for(stack: Process, endpoint: str) -> None:
    assert tandem("param", "get", "base.mass", "--connect", endpoint).stdout == "10\n"
    echo = ("topic", "echo", "base/status", "--count", "1", "--connect", endpoint)
    # It brakes while a sample is late.
    eventually(lambda: '"off"' in tandem(*echo).stdout, PATIENCE, "the base is off")


def test_the_marker_is_covered_and_uncovered(stack: Process, endpoint: str) -> None:
    for arguments, says, visible in (([], "covered", False), (["--off"], "uncovered", True)):
        assert tandem("cover", *arguments, "--connect", endpoint).stdout == f"the marker is {says}\n"
        done = tandem("topic", "echo", "sim/world", "--count", "1", "--connect", endpoint)
        assert f'"marker_visible": {str(visible).lower()}' in done.stdout


def test_the_person_plays_a_script_of_ones_own(stack: Process, endpoint: str, tmp_path: Path) -> None:
    script = tmp_path / "my.toml"
    script.write_text('# Mine.\n[[phase]]\ndo = "wait"\nuntil = "grasp"\npatience = 600\n')
    for given in (script.read_text(), str(script)):
        assert tandem("hand", given, "--connect", endpoint).stdout == "the person plays your script\n"
    missing = tandem("hand", str(tmp_path / "none.toml"), "--connect", endpoint)
    assert missing.returncode == 2 and "No such file" in missing.stderr
    done = tandem("topic", "echo", "sim/world", "--count", "1", "--connect", endpoint)
    assert '"doing": "wait"' in done.stdout
    refused = tandem("hand", script.read_text().replace("wait", "dance"), "--connect", endpoint)
    assert refused.returncode == 1 and "dance" in refused.stderr


def test_a_sensor_is_broken_and_mended(stack: Process, endpoint: str) -> None:
    def ft() -> str:
        return tandem("topic", "echo", "sensor/ft", "--count", "1", "--within", "1", "--connect", endpoint).stdout

    assert tandem("fault", "ft", "bias", "0,0,250,0,0,0", "--connect", endpoint).returncode == 0
    assert json.loads(ft())["force"][2] > 200.0
    tandem("fault", "ft", "off", "--connect", endpoint)
    assert ft() == ""
    refused = tandem("fault", "ft", "delay", "99", "--connect", endpoint)
    assert refused.returncode == 1 and "value is 99" in refused.stderr
    tandem("fault", "ft", "ok", "--connect", endpoint)
    assert abs(json.loads(ft())["force"][2]) < 200.0
    # The controller has latched the silence.
    assert tandem("resume", "--connect", endpoint).returncode == 0


def test_reset_sets_the_scene_back(stack: Process, endpoint: str) -> None:
    tandem("load", "10", "--connect", endpoint)
    assert tandem("reset", "--connect", endpoint).stdout == "the scene is as it was at the start\n"
    world = tandem("topic", "echo", "sim/world", "--count", "1", "--connect", endpoint).stdout
    assert json.loads(world)["bag"] is None


def test_stop_is_latched_until_resume(stack: Process, endpoint: str) -> None:
    assert tandem("stop", "by hand", "--connect", endpoint).returncode == 0
    status = tandem("status", "--connect", endpoint)
    assert status.returncode == 1
    assert "by hand" in status.stdout
    assert "tandem resume" in status.stdout
    assert tandem("resume", "--connect", endpoint).returncode == 0
    assert "stopped" not in tandem("status", "--connect", endpoint).stdout


def test_a_killed_controller_is_named_and_can_be_started_again(stack: Process, endpoint: str, tmp_path: Path) -> None:
    os.kill(pids(endpoint)["controller"], signal.SIGKILL)
    done = tandem("status", "--connect", endpoint)
    assert done.returncode == 1
    assert re.search(r"wrong: controller is lost: .*tandem start controller", done.stdout), done.stdout
    eventually(lambda: "controller: lost: ended with signal SIGKILL" in stack.output, PATIENCE, "up shows it")
    with Process("services.cli", ["start", "controller", "--connect", endpoint], tmp_path / "again"):
        eventually(lambda: "controller" in pids(endpoint), PATIENCE, "the controller runs again")
        eventually(
            lambda: re.search(
                r"^controller +(ok|degraded)", tandem("status", "--connect", endpoint).stdout, re.MULTILINE
            ),
            PATIENCE,
            "status is content with it",
        )


def test_a_second_stack_on_the_same_port_is_refused(stack: Process, endpoint: str) -> None:
    done = tandem("up", "--connect", endpoint)
    assert done.returncode == 1
    assert "cannot be used" in done.stderr and "sim, wrench of robot tiago run there" in done.stderr


def test_everything_ends_with_it(stack: Process, endpoint: str) -> None:
    started = pids(endpoint)
    assert {"router", "sim", "wrench", "base"} <= started.keys()
    stack.signal(signal.SIGINT)
    assert stack.wait(20) == 0
    assert not any(exists(pid) for pid in started.values())
    assert stack.output.endswith("all processes ended\n")
