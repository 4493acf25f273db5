"""The load experiment with a bridge to the simulated ROS robot in place of the simulation: the same claims hold."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import pytest

from benchmarks.experiment_stack import Staged, play_run
from services.experiment.load.load import LOAD
from services.experiment.load.load_claims import judge
from services.experiment.load.load_measures import measure
from services.sim.camera.head_camera import Rendering
from services.sim.camera.view import Scenery
from shared.messages import Stop
from shared.topics import STOP
from tests.support.ros_far_side import RosRig

pytestmark = [pytest.mark.slow, pytest.mark.timeout(600)]

RELEASED_AT = 10**9  # [ns]


class Bridged(Staged):
    """A person releases the bridge's stop after a second."""

    def _add_robot(self, settings: Mapping[str, Any], rendering: Callable[[Scenery], Rendering]) -> None:
        rig = RosRig(stack=self.stack, robot={"scene": settings["scene"]}, rendering=rendering)
        self.runners |= rig.runners
        self.stack.scheduler.at(RELEASED_AT, lambda: self.stack.client.publish(STOP, Stop(False, "")))


def test_every_claim_holds_through_a_bridge() -> None:
    run = LOAD.run_named("certified-100")
    found = judge({run.name: run}, {run.name: measure(play_run(LOAD, run, staged_by=Bridged))})
    assert len(found) >= 2
    assert [f"{claim.text}: {claim.figure} ({claim.limit})" for claim in found if not claim.passed] == []
