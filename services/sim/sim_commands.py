"""What ``sim/command`` does: a request has been checked when it comes here, but for what depends on the scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from services.sim.robot.sensor_line import SensorLine
from services.sim.scene import bag, script
from services.sim.scene.panel_scene import PanelScene
from services.sim.scene.world import World
from shared.parameters import Refused
from shared.schema.fields import Number, Vector
from shared.schema.records import Record
from shared.sim_messages import HEAVIEST, LARGEST_FORCE, CoverMarker, Hand, Load, Push, Reset, SensorFault

LONGEST_DELAY = 5.0
"""[s]"""
WHITE = 255.0
"""Brightest value of a pixel."""
_AXES = {"ft": 6, "joints": 8}
_NO_PANEL = 'there is no panel in the scene "load"; start with scene="full", the default, or "carry"'


class Commands:
    """Carries out requests on a world and its sensors' lines."""

    def __init__(self, world: World, lines: Mapping[str, SensorLine]) -> None:
        self._world = world
        self._lines = lines

    def carry_out(self, request: Record) -> None:
        """Carry out one request.

        Raises:
            Refused: with one line that names what was given and what is allowed; nothing has happened then.
            InvalidField: the same, for a fault's value.
        """
        match request:
            case Reset():
                for line in self._lines.values():
                    line.break_down("ok", (0.0,))
                self._world.reset()
            case Load(mass=mass):
                if 0.0 < mass < bag.LIGHTEST:
                    allowed = f"0 (take the bag off) or {bag.LIGHTEST:g} to {HEAVIEST:g} kg"
                    raise Refused(f"mass is {mass:g} kg, allowed is {allowed}")
                self._world.load(mass)
            case Push(force=force, torque=torque, duration=duration):
                self._world.push(force, torque, duration)
            case Hand(script=text, target=target):
                person = self._panel_scene("hand").person
                if text is None:
                    assert target is not None
                    person.guide(target)
                else:
                    person.act(script.read(text))
            case CoverMarker(covered=covered):
                self._panel_scene("cover_marker").covered = covered
            case SensorFault(target=target, kind=kind, value=value):
                if target == "camera":
                    self._panel_scene("target is 'camera'")
                self._lines[target].break_down(kind, _extent(target, kind, value))

    def _panel_scene(self, asked: str) -> PanelScene:
        """The panel and the person; Refused if there are none."""
        if self._world.panel_scene is None:
            raise Refused(f"{asked}: {_NO_PANEL}")
        return self._world.panel_scene


def _extent(target: str, kind: str, value: Any) -> Sequence[float]:
    """How bad a fault is: nothing, one number, or one for each axis."""
    if kind == "delay":
        return (Number("s", minimum=0.0, maximum=LONGEST_DELAY).check(value, "value"),)
    if kind != "bias":
        return (0.0,)
    if target == "camera":
        return (Number("of 255", minimum=-WHITE, maximum=WHITE).check(value, "value"),)
    several = isinstance(value, (list, tuple))
    bias = Vector("N, Nm or rad", size=_AXES[target] if several else 1, minimum=-LARGEST_FORCE, maximum=LARGEST_FORCE)
    return bias.check(value if several else [value], "value").tolist()
