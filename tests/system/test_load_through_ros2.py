"""The load experiment through real processes and ROS 2: bridge, and the simulated robot, under rmw_zenoh or DDS.

Before the one under DDS stands the real zenoh-bridge-ros2dds.
What fails for a machine that is too busy is not judged by the experiment itself; in simulated time all of it is, see
test_load_through_bridge.py.
"""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

import pytest

from shared.messages import Stop
from shared.topics import STATE_ROBOT, STOP
from shared.wire.client import Client
from shared.wire.zenoh import ZenohBus
from tests.conftest import Router, StartProcess
from tests.support import ros1, ros2, ros2dds
from tests.support.verdicts import FAILED, NOT_JUDGED, PASSED, failed
from tests.support.wait import eventually, throughout

pytestmark = [pytest.mark.processes, pytest.mark.slow, pytest.mark.timeout(300)]
RUN = "certified-100"
READY = 60.0  # [s]
PLAYED = 150.0  # [s]


@pytest.mark.parametrize("dialect", ["rmw_zenoh", "ros2dds"])
def test_no_claim_of_the_load_experiment_fails(
    router: Router, start: StartProcess, tmp_path: Path, dialect: str
) -> None:
    def on_the_bus(module: str, *options: str, **environment: str) -> None:
        start(module, "--connect", router.endpoint, *options, environment=environment)

    environment = (
        ros2.robot(start, router.endpoint, rate=ros1.USUAL)
        if dialect == "rmw_zenoh"
        else ros2dds.robot(start, tmp_path, router.endpoint, ros1.USUAL)
    )
    settings = start("services.experiment", "settings", "load", "--run", RUN)
    assert settings.wait() == PASSED
    config = tmp_path / "load.toml"
    config.write_text(settings.output, encoding="utf-8")
    on_the_bus(
        "services.bridge_ros2", *("--set", f'dialect="{dialect}"', "--set", "require_enable=false"), **environment
    )
    for name in ("wrench", "controller"):
        on_the_bus(f"services.{name}", "--config", str(config))
    with closing(ZenohBus(connect=router.endpoint)) as bus:
        _release(Client(bus))
    played = start(
        *("services.experiment", "run", "load", "--run", RUN, "--no-film", "--out", str(tmp_path / "report")),
        *("--connect", router.endpoint),
    )
    assert played.wait(PLAYED) in (PASSED, FAILED, NOT_JUDGED) and not failed(played.output), played.output
    assert f"pass  {RUN}: stays within every limit, force and torque, until the heavier bag" in played.output


def _release(client: Client) -> None:
    """Until the robot stays free: processes that start hold it up."""
    status = client.watch(STATE_ROBOT)

    def free() -> bool:
        return status.latest is not None and status.latest.message.mode != "stopped"

    def released() -> bool:
        client.publish(STOP, Stop(False))
        try:
            eventually(free, 0.5)
            throughout(free, 3.0)
        except AssertionError:
            return False
        return True

    eventually(released, READY, lambda: f"released: {status.latest and status.latest.message.reason}")
