"""THE table of what is drawn: a row for each topic, with the functions that draw its messages.

Every function takes a stream of rerun and messages, and knows nothing of where the stream goes or whether it is live.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import rerun as rr

from services.viewer.draw import camera, curves, scene, states, tool
from services.viewer.draw.robot import Robot, base
from services.viewer.draw.states import HEALTH, PHASES
from services.viewer.sample import Newest, Sample
from shared import topics as t
from shared.processes import HEALTHY
from shared.topics import health_topic

Draw = Callable[[rr.RecordingStream, Sample, Newest], None]
"""Draws the newest message at the time that the stream is set to."""
Plot = Callable[[rr.RecordingStream, Sequence[Sample]], None]
"""Adds messages, at least one, to curves at their own times."""


@dataclass(frozen=True)
class Row:
    """How the messages of one topic are drawn.

    Attributes:
        draw: the newest, often.
        plot: all, now and then.
        states: by entity, the word that the newest one says.
        entities: that are taken away when nothing more is heard.
    """

    draw: Draw | None = None
    plot: Plot | None = None
    states: Callable[[Any], Mapping[str, str]] = lambda message: {}
    entities: tuple[str, ...] = ()


def table(robot: Robot) -> dict[str, Row]:
    """Key -> row, for a robot whose shapes are in the stream."""
    return {
        t.STATE_JOINTS.key: Row(robot.joints),
        t.STATE_BASE.key: Row(base, curves.base_state, entities=(f"{curves.BASE}/measured",)),
        t.STATE_EE.key: Row(
            tool.pose,
            curves.tool,
            entities=(tool.POSE, f"{curves.SPEED}/measured", f"{curves.TURN}/measured"),
        ),
        t.STATE_ROBOT.key: Row(
            plot=curves.robot,
            states=lambda message: {f"{PHASES}/robot": message.mode},
            entities=(f"{curves.SPEED}/largest", f"{curves.TURN}/largest"),
        ),
        t.SENSOR_CAMERA.key: Row(camera.picture, entities=(camera.CAMERA,)),
        t.WRENCH_EXTERNAL.key: Row(tool.wrench, curves.wrench, entities=(tool.WRENCH, curves.WRENCH)),
        t.CONTROL_TARGET.key: Row(tool.target),
        t.CONTROL_STATUS.key: Row(
            tool.limits,
            curves.control,
            lambda message: {f"{PHASES}/control": message.state},
            (tool.LIMITS, tool.ACTIVE, tool.GHOST, curves.LIMIT, curves.USED, curves.MARGIN, curves.CERTIFICATE),
        ),
        t.COMMAND_EE_TWIST.key: Row(
            plot=curves.command, entities=(f"{curves.SPEED}/commanded", f"{curves.TURN}/commanded")
        ),
        t.BASE_STATUS.key: Row(
            plot=curves.base_status,
            states=lambda message: {f"{PHASES}/base": message.state},
            entities=(f"{curves.BASE}/commanded",),
        ),
        t.TASK_STATUS.key: Row(
            camera.marker, states=lambda message: {f"{PHASES}/task": message.state}, entities=(camera.MARKER,)
        ),
        t.SIM_WORLD.key: Row(scene.world, states=_person, entities=(scene.PANEL, scene.HANDS, scene.BAG)),
        **{health_topic(name).key: Row(plot=curves.loop(name), states=_health(name)) for name in HEALTHY},
    }


def _person(world: Any) -> Mapping[str, str]:
    """What a simulated person is about, if there is one."""
    return {f"{PHASES}/person": world.hand.doing} if world.hand is not None and world.hand.doing else {}


def _health(name: str) -> Callable[[Any], Mapping[str, str]]:
    return lambda message: {f"{HEALTH}/{name}": message.state}


def style(rec: rr.RecordingStream) -> None:
    """Everything that stays as it is: colours, names, widths."""
    for part in (tool, scene, camera, curves):
        part.style(rec)
    states.style(rec, HEALTHY)
