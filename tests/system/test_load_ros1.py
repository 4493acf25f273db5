"""The load experiment with real processes and a real ROS 1 between bridge and robot: the claims hold as elsewhere.

What a busy machine has spoilt is not judged (exit status 4); no claim may fail.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from services.cli.stack.plan import write_config
from services.experiment.load.load import LOAD
from shared.messages import Stop
from shared.topics import STATE_ROBOT, STOP
from tests.conftest import Router, StartProcess
from tests.support import ros1
from tests.support.stand_in import StandIn
from tests.support.verdicts import FAILED, NOT_JUDGED, PASSED, failed
from tests.support.wait import eventually

pytestmark = [pytest.mark.processes, pytest.mark.slow, pytest.mark.timeout(600)]


def test_no_claim_fails_through_a_bridge_and_ros_1(start: StartProcess, router: Router, tmp_path: Path) -> None:
    run = LOAD.run_named("certified-100")
    config, folder = str(write_config(run.settings, tmp_path / "config.toml")), tmp_path / "runs" / run.name
    folder.mkdir(parents=True)
    at = ("--connect", router.endpoint)
    environment = dict(ros1.robot(start, router.endpoint, rate=ros1.USUAL))
    for service in ("wrench", "controller"):
        start(f"services.{service}", *at, "--config", config, environment={"XDG_STATE_HOME": str(tmp_path)})
    bridge = start("services.bridge_ros1", *at, "--set", "require_enable=false", environment=environment)
    with StandIn(router.endpoint, "robot") as operator:
        status = operator.client.watch(STATE_ROBOT)

        def released() -> bool:
            operator.client.publish(STOP, Stop(False))
            return status.latest is not None and status.latest.message.mode != "stopped"

        eventually(released, 60.0, lambda: f"{status.latest}\n{bridge.output}", every=0.5)
        player = start("services.experiment", "play", "load", *at, "--run", run.name, "--out", str(folder))
        assert player.wait(300.0) == 0, f"{player.output}\n{status.latest}"
    judge = start("services.experiment", "report", str(folder.parent))
    assert judge.wait(200.0) in (PASSED, FAILED, NOT_JUDGED) and not failed(judge.output), judge.output
    assert f"pass  {run.name}: stays within every limit, force and torque, until the heavier bag" in judge.output
