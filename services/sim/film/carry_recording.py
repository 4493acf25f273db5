"""A recorded carry as its film needs it.

The recording holds series over one ``time`` (N,) [s]: ``joint_names`` (n,), ``joint_positions`` (N, n) [m, rad];
``base`` (N, 3) = x, y [m], yaw [rad]; ``panel_position`` (N, 3) [m] and ``panel_orientation`` (N, 4); the place of the
person's hands, ``hand_position`` (N, 3) [m], and what they do to the panel, ``hand_force`` (N, 3) [N], all in world;
``person_holds`` (N,); in base the panel's ``force`` (N, 3) [N] on the tool, the ``wrench`` (N, 6) [N, Nm] less the
nominal one, and its ``limit`` (N, 6), NaN while there is none; whether the marker is ``covered`` and the camera is
``looking``; ``caption`` (N,). Besides ``parameters``, those of the simulation, and ``moment_times`` (M,) [s] with
``moment_captions`` (M,).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from services.sim.camera.view import Scenery, View
from services.sim.parameters import SimParameters
from services.sim.robot.head import Head
from services.sim.robot.kinematics import CARRY_HOME
from services.sim.scene.panel import CLEARED, Panel
from shared.loop.config import Misconfigured
from shared.parameters import Refused
from shared.robot import tiago
from shared.spatial import Array, rotation_from_vector, rotation_matrix

SERIES = (
    "joint_positions",
    "base",
    "panel_position",
    "panel_orientation",
    "hand_position",
    "hand_force",
    "person_holds",
    "force",
    "wrench",
    "limit",
    "covered",
    "looking",
    "caption",
)
_VIEW_SMOOTHING = 1.5
"""Time constant [s] with which the view follows."""
_HANDS_MOVE = 0.8
"""Time [s] that the person's hands take to the panel and back."""


@dataclass(frozen=True)
class Moment:
    """What is to be seen at an instant, in world if nothing else is said.

    Attributes:
        time: since the beginning [s].
        joints: positions [m, rad] by name.
        base: x, y [m] and heading [rad].
        panel, panel_rotation: centre (3,) [m], (3, 3).
        trestles: middles (2, 3) [m] of their upper edges, None once they are taken away.
        covered: whether the marker is.
        looking: whether the head camera is in use.
        hands: where the person holds the panel (3,) [m].
        hands_force: of the person on the panel (3,) [N].
        holding: 1 with the person's hands on the panel, 0 with hanging arms.
        force: of the panel on the gripper (3,) [N].
        wrench, limit: (6,) [N, Nm] in base; NaN if there is no limit yet.
        caption: what happens, for people.
        centre: what the view follows (2,) [m].
    """

    time: float
    joints: Mapping[str, float]
    base: Array
    panel: Array
    panel_rotation: Array
    trestles: Array | None
    covered: bool
    looking: bool
    hands: Array
    hands_force: Array
    holding: float
    force: Array
    wrench: Array
    limit: Array
    caption: str
    centre: Array


class CarryRun:
    """A recorded carry.

    Attributes:
        time: of the samples (N,) [s].
        scenery: what the camera sees and does not change.
        moments: time [s] and caption of what is worth a still picture.

    Args:
        data: what the recording holds.

    Raises:
        Misconfigured: if that is not what a film needs; one line.
    """

    def __init__(self, data: Mapping[str, Any]) -> None:
        self.time: Array = data["time"]
        rows = len(self.time)
        self._series = {name: data[name] for name in SERIES}
        lengths = {name: len(column) for name, column in self._series.items()}
        if rows < 2 or any(length != rows for length in lengths.values()):
            told = ", ".join(f"{name} {length}" for name, length in lengths.items())
            raise Misconfigured(f"wanted series of one length, at least 2, got time {rows}, {told}")
        self._names = [str(name) for name in data["joint_names"]]
        try:
            parameters = SimParameters.of(data["parameters"])
        except Refused as problem:
            raise Misconfigured(f"parameters: {problem}") from None
        self.scenery: Scenery = parameters.scenery()
        self.moments = [
            (float(time), str(caption))
            for time, caption in zip(data["moment_times"], data["moment_captions"], strict=True)
        ]
        panel = Panel(parameters.panel_scene().panel)
        lifted = self._series["panel_position"][:, 2] > panel.body.position[2] + CLEARED
        self._supported = ~np.maximum.accumulate(lifted)
        self._trestles = panel.trestles
        self._holding = _eased(self._series["person_holds"], self.time, _HANDS_MOVE)
        self._centre = _smooth(self._series["base"][:, :2], self.time, _VIEW_SMOOTHING)
        self._head = Head(CARRY_HOME)

    def row(self, time: float) -> int:
        """Row of the newest sample at a time [s]."""
        return max(0, int(np.searchsorted(self.time, time, side="right")) - 1)

    def at(self, time: float) -> Moment:
        """What is to be seen at a time [s] of the recording."""
        row = self.row(time)
        now = {name: column[row] for name, column in self._series.items()}
        return Moment(
            time - float(self.time[0]),
            dict(zip(self._names, now["joint_positions"].tolist(), strict=True)),
            now["base"],
            now["panel_position"],
            rotation_matrix(now["panel_orientation"]),
            self._trestles if self._supported[row] else None,
            bool(now["covered"]),
            bool(now["looking"]),
            now["hand_position"],
            now["hand_force"],
            float(self._holding[row]),
            rotation_from_vector((0.0, 0.0, now["base"][2])).dot(now["force"]),
            now["wrench"],
            now["limit"],
            str(now["caption"]),
            self._centre[row],
        )

    def view(self, moment: Moment) -> View:
        """What the head camera sees then."""
        x, y, yaw = moment.base
        to_base = rotation_from_vector((0.0, 0.0, -yaw))
        origin = np.array((x, y, 0.0))
        self._head.position = np.array([moment.joints[name] for name in tiago.HEAD])
        position, rotation = self._head.camera(moment.joints[tiago.TORSO])
        supports = None
        if moment.trestles is not None:
            supports = (moment.trestles - origin).dot(to_base.T), -float(yaw)
        return View(
            position,
            rotation,
            moment.joints,
            to_base.dot(moment.panel - origin),
            to_base.dot(moment.panel_rotation),
            supports,
            moment.covered,
        )


def _smooth(series: Array, time: Array, width: float) -> Array:
    """Gaussian averages (N, k) over a width [s] before and after, as a calm hand leads a camera."""
    rows = max(1, round(width / float(np.median(np.diff(time)))))
    weights = np.exp(-0.5 * (np.arange(-3 * rows, 3 * rows + 1) / rows) ** 2)
    padded = np.pad(series, ((3 * rows, 3 * rows), (0, 0)), mode="edge")
    columns = [np.convolve(column, weights / weights.sum(), mode="valid") for column in padded.T]
    return np.column_stack(columns)


def _eased(switch: Array, time: Array, duration: float) -> Array:
    """A switch (N,) as a share [0, 1] that takes a time [s] for each change, and begins and ends gently."""
    share, level = np.empty(len(time)), float(switch[0])
    for row, on in enumerate(switch):
        step = (time[row] - time[max(0, row - 1)]) / duration
        level = float(np.clip(float(on), level - step, level + step))
        share[row] = level * level * (3.0 - 2.0 * level)
    return share
