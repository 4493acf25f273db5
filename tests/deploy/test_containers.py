"""The stack in containers: it comes up and moves, and what is stopped, killed or hung comes back.

Skipped by name where there are no containers; with TANDEM_CONTAINERS=required, as in .ci/run, it fails instead.
"""

from __future__ import annotations

import errno
import functools
import json
import os
import re
import shutil
import subprocess
import sys
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml

from shared.processes import PROCESSES, ROUTER, VIEWER
from tests.support import compose
from tests.support.compose import Compose
from tests.support.wait import eventually as _eventually

pytestmark = [pytest.mark.processes, pytest.mark.slow, pytest.mark.timeout(1500)]

BY_ITSELF = [process.name for process in PROCESSES if process.started != "by hand"]
LASTING = [*BY_ITSELF, VIEWER.name]
INTRUDER = Path(__file__).with_name("intruder.py")
PATIENCE = 60.0  # [s]
SOMEBODY = 12345
"""Owner of the folder of reports, if the tests may choose one."""
eventually = functools.partial(_eventually, every=1.0)
"""A look at containers takes the cores from what runs in them."""


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
    compose.wanted()
    override = tmp_path_factory.mktemp("compose") / "runs.yml"
    services: dict[str, Any] = {"experiment": {"volumes": [f"{runs}:/opt/tandem/runs"]}}
    services |= {name: {"healthcheck": {"interval": "5s"}} for name in ("wrench", VIEWER.name)}
    override.write_text(yaml.safe_dump({"services": services}))
    with Compose(f"tandem-test-{os.getpid()}", override) as stack:
        stack.do("up", "-d")
        yield stack


def alive(stack: Compose) -> bool:
    """Whether everybody says how it is; a busy machine makes some degraded."""
    said = re.findall(r"^(\w+) +(?:ok|starting|degraded)", stack.tandem("status").stdout, re.MULTILINE)
    return set(said) >= {*BY_ITSELF} - {ROUTER.name}


def moves(stack: Compose) -> bool:
    """Whether the robot may move now and then; what a busy machine has latched is released."""
    stack.tandem("resume")
    return any(said["mode"] == "ready" for said in stack.newest("state/robot", 200))


def test_the_carry_begins_by_itself(stack: Compose) -> None:
    eventually(lambda: "approaching" in stack.log("experiment"), PATIENCE, lambda: stack.log("experiment"))


def test_everybody_comes_with_a_certificate_and_sees_no_key_but_its_own(stack: Compose) -> None:
    assert stack.log("keys").count("made an authority, and certificates for router, sim, ") == 1
    look = ("find", "/keys", "-type", "f", "-printf", "%p %u %m\\n")
    for name in BY_ITSELF:
        seen = sorted(stack.do("exec", "-T", name, *look).split("\n"))[1:]
        modes = {"authority": 644, "certificate": 644, "key": 600}
        assert seen == [f"/keys/{name}/{file}.pem {name} {mode}" for file, mode in modes.items()]
    assert stack.do("exec", "-T", VIEWER.name, "find", "/keys", "-name", "key.pem").split() == ["/keys/page/key.pem"]
    others = stack.run("run", "--rm", "-T", "--entrypoint", "find", "tandem", "/keys", "-name", "key.pem")
    assert others.stdout.split() == ["/keys/operator/key.pem"]
    assert "robot tiago on tls/router:7447" in stack.tandem("status").stdout


def linked(stack: Compose) -> bool:
    """Whether everybody of the chain says that the links stand which it needs."""
    said = [stack.newest(f"health/{name}")[0]["links"] for name in ("wrench", "controller", "base", "task")]
    return all(links and all(links.values()) for links in said)


def test_the_chain_has_direct_links(stack: Compose) -> None:
    eventually(lambda: linked(stack), PATIENCE, "the links stand")


def page(stack: Compose, path: str, body: bytes | None = None) -> dict[str, Any]:
    """What the page answers to a browser on this machine."""
    here = f"http://127.0.0.1:{stack.page}"
    asked = urllib.request.Request(here + path, body, {"Origin": here, "X-Tandem": "page"})
    with urllib.request.build_opener(urllib.request.ProxyHandler({})).open(asked, timeout=30.0) as answer:
        return json.load(answer)


def test_the_page_stops_the_robot_and_is_on_no_other_network(stack: Compose) -> None:
    assert page(stack, "/stop", b"{}") == {"ok": True, "said": "stopped: the robot shows it"}
    assert stack.newest("state/robot")[0]["mode"] == "stopped"
    released: list[dict[str, Any]] = []

    def release() -> bool:
        released.append(page(stack, "/release", b"{}"))
        return released[-1]["ok"]

    # On a busy machine the controller latches a late sensor once more.
    eventually(release, PATIENCE, lambda: str(released))
    eventually(lambda: stack.health("viewer")[0] == "healthy", PATIENCE, lambda: str(stack.health("viewer")))
    reach = "import socket, sys; print(socket.socket().connect_ex((sys.argv[1], int(sys.argv[2]))))"
    for port in ("9090", "9091"):
        tried = ("run", "--rm", "-T", "--entrypoint", "python", "tandem", "-c", reach, "viewer", port)
        assert stack.do(*tried).strip() == str(errno.ECONNREFUSED), "whoever is on the bus finds nobody there"


def intrude(stack: Compose, endpoint: str, folder: Path) -> dict[str, bool]:
    """What somebody achieves in a container of the same network who has a folder's certificates."""
    mounts = ("-v", f"{INTRUDER}:/opt/tandem/intruder.py:ro", "-v", f"{folder}:/stranger:ro", "-u", str(os.getuid()))
    command = ("--entrypoint", "python", "tandem", "-m", "intruder", endpoint, "/stranger")
    done = stack.run("run", "--rm", "-T", *mounts, *command)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.fixture
def strangers(stack: Compose, tmp_path: Path) -> dict[str, Path]:
    """Folders of whoever has no certificate, one of a foreign authority, one that has ended; and a good one."""
    folders = {name: tmp_path / name for name in ("nobody", "foreign", "expired", "operator")}
    for folder in folders.values():
        folder.mkdir()
    for name, days in (("expired", "0"), ("operator", "1")):
        options = ("--only", "operator", "--into", "/stranger", "--days", days)
        stack.do("run", "--rm", "-T", "-v", f"{folders[name]}:/stranger", "keys", *options)
    foreign = [sys.executable, "-m", "services.cli", "keys", str(tmp_path / "keys"), "--only", "operator"]
    subprocess.run(foreign, check=True, capture_output=True)
    shutil.copytree(tmp_path / "keys" / "operator", folders["foreign"], dirs_exist_ok=True)
    for name in ("nobody", "foreign"):
        # The authority's certificate is no secret: they take the router for the right one.
        shutil.copy(folders["operator"] / "authority.pem", folders[name])
    return folders


def test_a_stranger_in_the_network_is_refused_and_nothing_moves(stack: Compose, strangers: dict[str, Path]) -> None:
    stack.tandem("resume")
    for endpoint, name in (
        ("tcp/router:7447", "operator"),
        *((f"tls/{at}", name) for at in ("router:7447", "robot:7448") for name in ("nobody", "foreign", "expired")),
    ):
        achieved = intrude(stack, endpoint, strangers[name])
        assert not any(achieved.values()), (endpoint, name, achieved)
        assert stack.newest("state/robot")[0]["mode"] != "stopped"
    for reason in ("no TLS", "no certificate", "of another authority", "expired"):
        assert re.search(rf"refused a connection.*: {reason}", stack.log("router"))
    assert intrude(stack, "tls/router:7447", strangers["operator"]) == {"router": True, "heard": True, "answered": True}
    assert stack.newest("state/robot")[0]["mode"] == "stopped"
    assert stack.tandem("resume").returncode == 0


def test_another_experiment_is_played_and_its_report_is_its_reader_s(stack: Compose, runs: Path) -> None:
    stack.do("stop", "experiment")
    assert stack.inspect("experiment", "State", "ExitCode") == 0, "it gives the controller back what it had"
    done = stack.run("run", "--rm", "-T", "experiment", "load", "--no-film", timeout=600.0)
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
    stack.do("kill", "-s", "STOP", "router")
    try:
        eventually(lambda: "nobody could stop the robot: the router" in stack.log("sim"), PATIENCE, "its reason")
    finally:
        stack.do("kill", "-s", "CONT", "router")
    eventually(lambda: "it can be stopped again" in stack.log("sim"), PATIENCE, "that it is over")
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
    eventually(lambda: alive(stack), PATIENCE, lambda: stack.tandem("status").stdout)


def shown(stack: Compose) -> str:
    """The certificate that the robot shows to whoever dials it directly; empty if it does not listen."""
    look = "import ssl; print(ssl.get_server_certificate(('robot', 7448)))"
    return stack.run("run", "--rm", "-T", "--entrypoint", "python", "tandem", "-c", look).stdout


def test_new_keys_are_taken_and_old_ones_refused_after_a_theft(stack: Compose, strangers: dict[str, Path]) -> None:
    stack.do("up", "-d")
    assert "nothing to do for router, sim" in stack.log("keys").splitlines()[-1]
    assert "router (was asked for)" in stack.do("run", "--rm", "-T", "keys", "--renew", "--only", "router")
    eventually(lambda: "listening anew" in stack.log("router"), PATIENCE, "the router takes its new one over")
    eventually(lambda: alive(stack), PATIENCE, "all are back")
    before = shown(stack)
    assert "sim (was asked for)" in stack.do("run", "--rm", "-T", "keys", "--renew", "--only", "sim")
    eventually(lambda: shown(stack) not in ("", before), PATIENCE, "the robot shows its new one at its direct links")
    eventually(lambda: linked(stack), PATIENCE, "the links stand again")
    assert "made an authority" in stack.do("run", "--rm", "-T", "keys", "--revoke")
    eventually(lambda: stack.log("router").count("listening anew") == 2, PATIENCE, "the router takes its new one over")
    eventually(lambda: alive(stack) and linked(stack), PATIENCE, "all are back, with new ones")
    for endpoint in ("tls/router:7447", "tls/robot:7448"):
        assert not any(intrude(stack, endpoint, strangers["operator"]).values()), endpoint
    stack.do("down")
    stack.do("up", "-d", *LASTING)
    assert "nothing to do for router, sim" in stack.log("keys").splitlines()[-1]
    eventually(lambda: alive(stack), PATIENCE, "it comes up with the keys that are there")


def test_everybody_ends_by_itself_within_two_seconds(stack: Compose) -> None:
    stack.do("stop")
    assert {name: stack.inspect(name, "State", "ExitCode") for name in LASTING} == dict.fromkeys(LASTING, 0)
