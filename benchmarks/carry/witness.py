"""Sees what is really the case: a service beside the others that looks into the simulation."""

from __future__ import annotations

from typing import Any

import numpy as np

from services.sim.simulator import Simulator
from shared import topics
from shared.parameters import Parameters
from shared.service import Inputs, Output, Service, Wiring

PERIOD = 0.01  # [s]
COLUMNS = {
    "time": "simulated [s]",
    "state": "of the task",
    "wrench": "of the panel on the tool, base axes (6,) [N, Nm]",
    "nominal": "force along z [N]",
    "lowest": "end of the panel, above the ground [m]",
    "near": "end of the panel, the one in the gripper, above the ground [m]",
    "pitch": "of the panel's length; positive: the far end is higher [rad]",
    "upright": "sine of how far the panel's width points up [1]",
    "gripped": "whether both fingers press on the panel",
    "opening": "whether the gripper was told to open",
    "held": "whether the person holds the panel",
    "supported": "whether the trestles stand",
    "strain": "spring part of the person's hands (2,) [N, Nm]",
    "warned": "whether the task says that letting go now would tear the panel out of the gripper",
}
"""Of a sample, in this order."""


class Witness(Service[Parameters]):
    """Takes a sample a hundred times a second.

    Args:
        simulator: to look into.
        thickness: of the panel [m]: a gripper told to be wider than that was told to open.
        warning: what the task says when the gripper cannot hold the panel alone; "" if it can.
    """

    wiring = Wiring(
        "witness", driver=PERIOD, optional=(topics.CONTROL_TARGET, topics.TASK_STATUS, topics.COMMAND_GRIPPER)
    )
    max_delay = 1.0

    def __init__(self, simulator: Simulator, thickness: float, warning: str) -> None:
        super().__init__(Parameters())
        self._world = simulator.world
        self._thickness = thickness
        self._warning = warning
        self._samples: list[tuple[Any, ...]] = []

    def step(self, inputs: Inputs, dt: float) -> list[Output]:
        """One sample; nothing is said."""
        world = self._world
        assert world.panel_scene is not None
        scene, base = world.panel_scene, world.base
        panel, hands = scene.panel, scene.person.hands
        target, status = inputs.get(topics.CONTROL_TARGET), inputs.get(topics.TASK_STATUS)
        grip = inputs.get(topics.COMMAND_GRIPPER)
        force, torque = base.turned_back(world.contact_force), base.turned_back(world.contact_torque)
        rotation, half = panel.body.rotation, panel.half
        below = float(np.abs(rotation[2, 1:]).dot(half[1:]))
        near = float(panel.body.position[2] - half[0] * rotation[2, 0]) - below
        far = float(panel.body.position[2] + half[0] * rotation[2, 0]) - below
        self._samples.append(
            (
                world.time,
                "" if status is None else status.message.state,
                (*force, *torque),
                0.0 if target is None else float(target.message.nominal_force[2]),
                min(near, far),
                near,
                float(np.arcsin(np.clip(rotation[2, 0], -1.0, 1.0))),
                float(abs(rotation[2, 1])),
                world.gripper.holding,
                grip is not None and grip.message.opening > self._thickness,
                hands.holding,
                panel.supported,
                hands.strain,
                bool(self._warning) and status is not None and self._warning in status.message.reason,
            )
        )
        return []

    def seen(self) -> dict[str, np.ndarray]:
        """All samples, by the names of ``COLUMNS``."""
        return {name: np.array(column) for name, column in zip(COLUMNS, zip(*self._samples, strict=True), strict=True)}
