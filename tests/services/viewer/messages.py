"""A message of every topic that is drawn, as a robot in the middle of a carry would say it."""

from __future__ import annotations

import numpy as np

from shared import messages as m
from shared import sim_messages as s
from shared import topics as t
from shared.robot.tiago import JOINTS
from shared.schema.records import Record
from shared.topics import Topic
from tests.services.viewer.known import LIMIT, at, control, health, robot

LEVEL = (0.0, 0.0, 0.0, 1.0)
NOMINAL = np.array((0.0, 0.0, -7.0, 0.0, 0.0, 0.0))
TOOL = np.array((0.6, -0.3, 0.9))
BOUND = np.array((0.5, 0.5, 0.5, 0.02, 0.02, 0.02))


def camera(encoding: str = "jpeg", data: bytes = b"\xff\xd8\xff", focus: float = 500.0) -> m.CameraImage:
    return m.CameraImage(4, 2, encoding, data, (focus, focus, 2.0, 1.0), (), (0.2, 0.0, 1.2), LEVEL)


def wrench(force: float = -20.0, bound: float = 0.5) -> m.ExternalWrench:
    return m.ExternalWrench((1.0, 2.0, force), (0.1, 0.2, 0.3), (bound,) * 3 + (0.02,) * 3, "payload", "")


def world(panel: bool = True, bag: bool = True, hand: bool = True) -> s.SimWorld:
    return s.SimWorld(
        1.0,
        s.PanelState((1.0, 0.0, 0.8), LEVEL, (1.2, 0.6, 0.05)) if panel else None,
        s.BagState(2.0, 0.1) if bag else None,
        s.HandState((1.6, 0.0, 0.8), (2.0, 0.0, 5.0), (0.0,) * 3, "move", (1.7, 0.0, 0.8)) if hand else None,
        (0.0,) * 3,
        True,
    )


def joints(**positions: float) -> m.JointState:
    still = np.zeros(len(JOINTS))
    return m.JointState(tuple(JOINTS), [positions.get(name, 0.0) for name in JOINTS], still, still)


HELD = control("yielding", nominal=NOMINAL, **at(2, -1.0, 24.8))
SEEN = m.TaskStatus("approaching", 1.0, "", 0.0, 0.8, m.MarkerPose((0.8, 0.0, 0.8), LEVEL, 0.1))
MESSAGES: dict[Topic, Record] = {
    t.SENSOR_CAMERA: camera(),
    t.STATE_JOINTS: joints(),
    t.STATE_EE: m.EndEffector(TOOL, LEVEL, (0.03, 0.0, 0.04), (0.0, 0.0, 0.2)),
    t.STATE_BASE: m.BaseState((1.0, 2.0), 0.5, (0.1, 0.0, 0.2)),
    t.STATE_ROBOT: robot(),
    t.COMMAND_EE_TWIST: m.TwistCommand((0.06, 0.0, 0.08), (0.0, 0.0, 0.3)),
    t.WRENCH_EXTERNAL: wrench(),
    t.CONTROL_TARGET: m.ControlTarget((0.7, -0.3, 0.9), LEVEL, LIMIT[:3], LIMIT[3:]),
    t.CONTROL_STATUS: HELD,
    t.BASE_STATUS: m.BaseStatus("following", (1.0, 0.0, 0.0), (0.1, 0.0, 0.2)),
    t.TASK_STATUS: SEEN,
    t.SIM_WORLD: world(),
    t.health_topic("wrench"): health(),
}
