"""What ``sim/command`` understands: requests are checked here, before anything happens."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from services.sim.robot.sensor_line import KINDS, SensorLine
from services.sim.scene import bag, script
from services.sim.scene.world import World
from shared.parameters import Refused
from shared.spatial import Array

LARGEST_FORCE, LARGEST_TORQUE = 300.0, 50.0
"""Of a push [N, Nm]."""
LONGEST_PUSH = 600.0
FARTHEST = 20.0
"""Of a target of the person's hands [m]."""
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
        self._known = {
            "reset": self._reset,
            "load": self._load,
            "push": self._push,
            "hand": self._hand,
            "cover_marker": self._cover_marker,
            "fault": self._fault,
        }

    def carry_out(self, request: Mapping[str, Any]) -> None:
        """Carry out one request.

        Raises:
            Refused: with one line that names what was given and what is allowed; nothing has happened then.
        """
        command = request.get("command")
        if not isinstance(command, str) or command not in self._known:
            raise Refused(f"command is {command!r}, allowed are {', '.join(self._known)}")
        self._known[command](request)

    def _reset(self, _request: Mapping[str, Any]) -> None:
        for line in self._lines.values():
            line.break_down("ok", (0.0,))
        self._world.reset()

    def _load(self, request: Mapping[str, Any]) -> None:
        mass = _number(request, "mass", "kg", 0.0, bag.HEAVIEST)
        if 0.0 < mass < bag.LIGHTEST:
            allowed = f"0 (take the bag off) or {bag.LIGHTEST:g} to {bag.HEAVIEST:g} kg"
            raise Refused(f"mass is {mass:g} kg, allowed is {allowed}")
        self._world.load(mass)

    def _push(self, request: Mapping[str, Any]) -> None:
        force = _vector(request.get("force", [0.0] * 3), "force", "N", LARGEST_FORCE, 3)
        torque = _vector(request.get("torque", [0.0] * 3), "torque", "Nm", LARGEST_TORQUE, 3)
        self._world.push(force, torque, _number(request, "duration", "s", 0.0, LONGEST_PUSH))

    def _hand(self, request: Mapping[str, Any]) -> None:
        if self._world.carry is None:
            raise Refused(f"hand: {_NO_PANEL}")
        person = self._world.carry.person
        given, target = request.get("script"), request.get("target")
        if (given is None) == (target is None):
            raise Refused("hand takes either script, a name or TOML text, or target, 3 numbers in m")
        if target is not None:
            person.guide(_vector(target, "target", "m", FARTHEST, 3))
        elif isinstance(given, str):
            person.act(script.read(given))
        else:
            raise Refused(f"script is {given!r}, allowed is text")

    def _cover_marker(self, request: Mapping[str, Any]) -> None:
        if self._world.carry is None:
            raise Refused(f"cover_marker: {_NO_PANEL}")
        covered = request.get("covered", True)
        if not isinstance(covered, bool):
            raise Refused(f"covered is {covered!r}, allowed are true and false")
        self._world.carry.covered = covered

    def _fault(self, request: Mapping[str, Any]) -> None:
        target, kind = request.get("target"), request.get("kind")
        if target == "camera" and self._world.carry is None:
            raise Refused(f"target is 'camera': {_NO_PANEL}")
        if not isinstance(target, str) or target not in self._lines:
            raise Refused(f"target is {target!r}, allowed are {', '.join(self._lines)}")
        if not isinstance(kind, str) or kind not in KINDS:
            raise Refused(f"kind is {kind!r}, allowed are {', '.join(KINDS)}")
        value: Array = np.zeros(1)
        if kind == "delay":
            value = np.array([_number(request, "value", "s", 0.0, LONGEST_DELAY)])
        elif kind == "bias" and target == "camera":
            value = np.array([_number(request, "value", "of 255", -WHITE, WHITE)])
        elif kind == "bias":
            given = request.get("value")
            axes = _AXES[target] if isinstance(given, (list, tuple)) else 1
            value = _vector(given if axes > 1 else [given], "value", "N, Nm or rad", LARGEST_FORCE, axes)
        self._lines[target].break_down(kind, value.tolist())


def _number(request: Mapping[str, Any], name: str, unit: str, low: float, high: float) -> float:
    given = request.get(name)
    if isinstance(given, bool) or not isinstance(given, (int, float)) or not low <= given <= high:
        raise Refused(f"{name} is {given!r}, allowed is a number from {low:g} to {high:g} {unit}")
    return float(given)


def _vector(given: Any, name: str, unit: str, largest: float, size: int) -> Array:
    numbers = isinstance(given, (list, tuple)) and len(given) == size
    if not numbers or not all(
        isinstance(x, (int, float)) and not isinstance(x, bool) and math.isfinite(x) and abs(x) <= largest
        for x in given
    ):
        raise Refused(
            f"{name} is {given!r}, allowed are {size} numbers from {-largest:g} to {largest:g} {unit}"
        )
    return np.array(given, dtype=float)
