"""Contact between the gripper's fingers and the panel: nothing is held that two fingers and friction do not hold.

Each finger's pad presses on its side of the panel like a spring. Only while both do, friction carries forces along the
pads and a torque about the axis across them, together bounded by the limit surface

    (f / mu N)^2 + (t / mu N r)^2 <= 1

with N the pressure of both pads and r the mean distance of their area from its centre. Tilting between the pads is
resisted by their size and the strength of the fingers. All of it is as elastic as fingers, wrist and foam together, and
slips where it would exceed its bound.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from services.sim.robot.gripper import Gripper
from services.sim.scene.panel import Panel
from services.sim.scene.rigid_body import RigidBody
from shared.spatial import Array, cross

STIFFNESS, ANGULAR_STIFFNESS = 5000.0, 100.0
"""[N/m, Nm/rad] Of wrist, fingers and foam: those of the wrist in the quick model of the carry (docs/task.md)."""
DAMPING, ANGULAR_DAMPING = 35.0, 1.5
"""[Ns/m, Nms/rad] About 0.4 of critical for a panel of 1.5 kg held at one end."""
PAD_BEGIN, PAD_END = -0.01, 0.10
"""[m] Where the pads begin, at the palm, and end, along the tool's x axis: the fingers of ``tiago.urdf``."""
PAD_WIDTH = 0.05  # [m] of the pads along the tool's z axis: the fingers of ``tiago.urdf``

# Assumptions, nobody publishes them:
STRENGTH = 100.0  # [N] at which the gear of a finger gives way
CONTACT = 1.0  # [N] of each pad's pressure from which on it counts as contact
PARALLEL = math.cos(math.radians(20.0))  # faces further from parallel to the pads are bumped into, not gripped
PIVOT = math.cos(math.radians(60.0))
"""A panel that has turned between the pads by more than this, about the axis across them, is no longer between them."""
CLEARANCE = 0.002  # [m] by which the panel may be wider than the fingers' gap and still slip in between


@dataclass(frozen=True)
class Pads:
    """Where the panel is between the pads, in tool axes.

    Attributes:
        edge: of the panel along the tool's x axis [m].
        centre: of the covered part of the pads, on the panel's middle plane (3,) [m].
        covered: length [m] of that part.
        half: half the panel's thickness along the tool's y axis [m].
        parallel: whether its faces are.
    """

    edge: float
    centre: Array
    covered: float
    half: float
    parallel: bool


def locate(panel: Panel, position: Array, rotation: Array) -> Pads | None:
    """Where the panel is between the pads of a tool at a position (3,) [m] and rotation (3, 3) in world, if it is.

    The panel is gripped at the edge that it turns towards the robot, the one at its most negative x.
    """
    turned = rotation.T.dot(panel.body.rotation)
    centre = rotation.T.dot(panel.body.position - position)
    along, across, normal = turned.T
    if along[0] < PIVOT * math.hypot(along[0], along[2]) or math.hypot(along[0], along[2]) < PARALLEL:
        return None
    # The tool's x axis enters the panel where the panel's own x coordinate is minus half its length.
    edge = float((along.dot(centre) - panel.half[0]) / along[0])
    covered = PAD_END - max(edge, PAD_BEGIN)
    if covered <= 0.0:
        return None
    middle = np.array((PAD_END - 0.5 * covered, 0.0, 0.0))
    if abs(across.dot(middle - centre)) > panel.half[1]:
        return None
    parallel = abs(normal[1]) >= PARALLEL
    if parallel:
        middle[1] = normal.dot(centre - middle) / normal[1]
        half = panel.half[2] / abs(float(normal[1]))
        near = abs(middle[1]) < 0.1
    else:
        half = 0.0
        near = bool((np.abs(turned.T.dot(middle - centre)) < panel.half + PAD_WIDTH / 2.0).all())
    return Pads(edge, middle, covered, half, parallel) if near else None


class Grip:
    """What the gripper and the panel do to each other.

    Args:
        friction: coefficient between pads and foam.
        body: of the panel.
        step: duration [s] of one physics step.
    """

    def __init__(self, friction: float, body: RigidBody, step: float) -> None:
        self._friction = friction
        stiffness, damping = body.followed(ANGULAR_STIFFNESS, ANGULAR_DAMPING, step)
        self._spring = np.concatenate(((STIFFNESS,) * 3, stiffness[_AS_TOOL]))
        self._damper = np.concatenate(((DAMPING,) * 3, damping[_AS_TOOL]))
        self._stretch = np.zeros(6)
        self._barred = False
        self._between = False

    def wrench(self, gripper: Gripper, pads: Pads | None, twist: Array, dt: float) -> tuple[Array, Array] | None:
        """Force (3,) [N] and torque (3,) [Nm] on the panel at the pads' centre, tool axes; None if nothing touches.

        Args:
            gripper: whose pressures and holding are updated.
            pads: where the panel is.
            twist: of the panel relative to the tool at the pads' centre (6,), tool axes.
            dt: time [s] since the last call.
        """
        if pads is None:
            gripper.pressed, gripper.holding, self._between = (0.0, 0.0), False, False
            return None
        left = pads.half + float(pads.centre[1]) - gripper.left
        right = pads.half - float(pads.centre[1]) - gripper.right
        if not self._between:
            self._between = True
            self._barred = not pads.parallel or max(left, right) > CLEARANCE
        if self._barred:
            # The fingers' ends meet the panel's edge.
            gripper.pressed, gripper.holding = (0.0, 0.0), False
            return self._bumped(pads.covered, twist), np.zeros(3)
        away = float(twist[1])
        press_left = self._pressure(left, away)
        press_right = self._pressure(right, -away)
        gripper.left += max(0.0, press_left - STRENGTH) / STIFFNESS
        gripper.right += max(0.0, press_right - STRENGTH) / STIFFNESS
        gripper.pressed = (press_left, press_right)
        force = self._bumped(PAD_BEGIN - pads.edge, twist)
        force[1] = press_right - press_left
        gripper.holding = min(press_left, press_right) >= CONTACT
        if not gripper.holding:
            self._stretch = np.zeros(6)
            return force, np.zeros(3)
        held = self._held(press_left + press_right, pads.covered, twist, dt)
        return force + held[:3], held[3:]

    @staticmethod
    def _pressure(depth: float, closing: float) -> float:
        """Of one pad [N]: both together are as stiff as the wrist."""
        return max(0.0, 0.5 * (STIFFNESS * depth + DAMPING * closing)) if depth > 0.0 else 0.0

    @staticmethod
    def _bumped(depth: float, twist: Array) -> Array:
        """Force (3,) [N] on a panel that is ``depth`` [m] too far inside."""
        push = STIFFNESS * depth - DAMPING * float(twist[0]) if depth > 0.0 else 0.0
        return np.array((min(max(push, 0.0), 2.0 * STRENGTH), 0.0, 0.0))

    def _held(self, pressure: float, covered: float, twist: Array, dt: float) -> Array:
        """Force and torque (6,) [N, Nm] on the panel by friction and by the pads' size; none across the pads."""
        stretch = self._stretch + twist * dt
        stretch[1] = 0.0
        pull = self._spring * stretch + self._damper * twist
        pull[1] = 0.0
        most = self._friction * pressure
        radius = mean_radius(covered, PAD_WIDTH)
        pulled = math.hypot(pull[0], pull[2], pull[4] / radius)
        share = np.ones(6)
        if pulled > most:
            share[[0, 2, 4]] = most / pulled
        for axis, lever in ((3, PAD_WIDTH), (5, covered)):
            share[axis] = min(1.0, STRENGTH * lever / max(abs(pull[axis]), 1e-9))
        pull *= share
        # What slips drags its spring along.
        self._stretch = np.where(share < 1.0, pull / self._spring, stretch)
        return -pull


def mean_radius(length: float, width: float) -> float:
    """Mean distance [m] of a rectangle's points from its centre."""
    a, b = 0.5 * length, 0.5 * width
    d = math.hypot(a, b)
    return (d + a * a / (2.0 * b) * math.asinh(b / a) + b * b / (2.0 * a) * math.asinh(a / b)) / 3.0


def about_tool(force: Array, torque: Array, point: Array) -> Array:
    """Torque (3,) [Nm] about the tool's origin of a force (3,) and a torque (3,) at a point (3,) of the tool."""
    return torque + cross(point, force)


_AS_TOOL = [0, 2, 1]
"""Axes of the panel that lie along x, y and z of a tool that grips it."""
