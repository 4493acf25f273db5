"""A stack that runs already is made ready for a run, in simulated time."""

from __future__ import annotations

from pathlib import Path

import pytest

from services.controller.controller import Controller
from services.controller.parameters import ControllerParameters
from services.experiment.carry.carry import CARRY
from services.experiment.load.load import LOAD
from services.experiment.running import as_wanted, playable, set_back
from shared import topics
from shared.loop.stack import Stack
from shared.parameters import Refused
from shared.wire.bus import NoReply
from tests.support.carry_rig import CarryRig


@pytest.mark.slow
def test_a_carry_begins_anew_in_the_middle_of_one(tmp_path: Path) -> None:
    rig = CarryRig(tmp_path)
    scene = rig.services.simulator.world.panel_scene
    assert scene is not None
    start = scene.panel.body.position.copy()
    rig.carry_up_to("move")
    set_back(rig.client, pause=rig.stack.run)
    rig.stack.run(0.5)
    assert rig.task.state == "idle"
    assert scene.panel.body.position == pytest.approx(start)
    assert rig.movement(1.0) == pytest.approx((0.0, 0.0), abs=2e-3), "nobody pursues an old target"
    rig.client.ask(topics.WRENCH_TARE, {"duration": 1.0})
    rig.sim("hand", script="carry")
    rig.tell("start")
    rig.reaches("approaching")


def test_without_a_simulation_nothing_is_set_back() -> None:
    waited: list[float] = []
    with pytest.raises(NoReply, match="sim/command"):
        set_back(Stack().client, within=1.0, pause=waited.append)
    assert sum(waited) == pytest.approx(1.0)


def test_the_controller_has_the_parameters_of_a_run_while_it_lasts() -> None:
    stack = Stack()
    controller = Controller(ControllerParameters.of({"law": "paper", "contact_stiffness": 500.0}))
    stack.add(controller)
    run = LOAD.run_named("certified-100")
    before = controller.parameters
    with pytest.raises(Refused, match="broken off"), as_wanted(stack.client, run):
        assert controller.parameters == before.changed(run.settings["controller"])
        raise Refused("broken off")
    assert controller.parameters == before


def test_only_what_the_controller_decides_can_be_played_on_a_running_stack() -> None:
    assert playable(CARRY).name == "certified-omni"
    assert playable(LOAD, "stiffness-100").law == "stiffness"
    for experiment, name in ((LOAD, "paper-30"), (CARRY, "certified-none"), (CARRY, "certified-differential")):
        with pytest.raises(ValueError, match=f"{name}' needs a stack of its own: tandem run"):
            playable(experiment, name)
