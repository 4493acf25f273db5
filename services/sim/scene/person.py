"""The simulated person: does one thing after the other with the panel, going by what a person sees and feels.

The person sees the panel, both its ends and the robot's fingers, and feels force and torque in the hands, but knows
nothing of the robot's targets, forces or states.
"""

from __future__ import annotations

import math

import numpy as np

from services.sim.scene.hands import Hands
from services.sim.scene.panel import Panel
from services.sim.scene.script import Phase
from shared.spatial import GRAVITY, Array, rotation_from_vector

# Those of the quick model of the carry (docs/task.md):
ENOUGH_FORCE, ENOUGH_TORQUE = 30.0, 12.0
"""[N, Nm] Resistance above which the person stops going on, and waits for the other end to follow."""
HIGHER = 0.01  # [m] by which the other end may be higher than the person's own
LEVELLING = 0.15  # [rad/s] at which the hands turn to bring a higher end down

# Assumptions of what a careful person does:
GUIDED_SPEED = 0.15  # [m/s] of the hands on their way to a target given from outside
WAITING = 0.15  # [m] by which the other end is higher when the person's own is lowered no further
TOUCHING = 0.004  # [m] above the ground that look like none
RELAXING = 0.5  # [s] for taking over or leaving a weight, and time constant of easing off before the hands let go


class Person:
    """Moves where the hands want to be; what comes of it is up to the hands.

    Args:
        hands: at ease.

    Attributes:
        hands: where they want to be, and what they do to the panel.
    """

    def __init__(self, hands: Hands) -> None:
        self.hands = hands
        self._phases: tuple[Phase, ...] = ()
        self._target: Array | None = None
        self._begin_with(0)

    @property
    def asked(self) -> bool:
        """Whether the person has been asked to do anything."""
        return bool(self._phases) or self._target is not None

    @property
    def doing(self) -> str:
        """What the person is about, in one word; empty if nothing."""
        if self._target is not None:
            return "guided"
        return self._phases[self._index].do if self._index < len(self._phases) else ""

    def act(self, phases: tuple[Phase, ...]) -> None:
        """Do these things from now on, one after the other."""
        self._phases = phases
        self._target = None
        self._begin_with(0)

    def guide(self, target: Array) -> None:
        """Hold the panel, and bring the hands to a position (3,) [m] of the world."""
        self._target = target

    def step(self, panel: Panel, gripped: bool, dt: float) -> tuple[Array, Array]:
        """Force (3,) [N] and torque about its centre (3,) [Nm] on the panel, world axes.

        Args:
            panel: that the person sees and holds.
            gripped: whether the robot's fingers are closed on it, as anybody can see.
            dt: time [s] since the last call.
        """
        if self._target is not None:
            self._follow(panel, self._target, dt)
        elif self._index < len(self._phases):
            self._go_on(self._phases[self._index], panel, gripped, dt)
        return self.hands.step(panel, dt)

    def _begin_with(self, index: int) -> None:
        self._index = index
        self._elapsed = 0.0
        self._share = 0.0
        self._done_for = -1.0
        self._origin: tuple[Array, Array, float] | None = None

    def _go_on(self, phase: Phase, panel: Panel, gripped: bool, dt: float) -> None:
        hands = self.hands
        if self._origin is None:
            self._origin = hands.position, hands.rotation, hands.lifting
        self._elapsed += dt
        if self._done_for < 0.0:
            if self._does(phase, panel, gripped, dt) or self._elapsed > phase.patience:
                self._done_for = 0.0
            return
        self._done_for += dt
        if self._done_for >= phase.pause:
            self._begin_with(self._index + 1)

    def _does(self, phase: Phase, panel: Panel, gripped: bool, dt: float) -> bool:
        """Do a bit of a phase; true if it is done."""
        hands = self.hands
        if phase.do == "wait":
            return gripped == (phase.until == "grasp")
        if phase.do == "take_hold":
            hands.take_hold(panel)
            return True
        if phase.do == "let_go":
            # Not all at once: what the hands still press with would push the panel over.
            hands.ease(panel, dt / RELAXING)
            self._share += dt / (5.0 * RELAXING)
            if self._share >= 1.0:
                hands.let_go()
            return self._share >= 1.0
        if not hands.holding:
            hands.take_hold(panel)
            self._origin = hands.position, hands.rotation, hands.lifting
        assert self._origin is not None
        position, rotation, lifting = self._origin
        if phase.do == "lower":
            return self._lower(phase, panel, dt)
        if phase.do == "turn":
            angle = math.radians(phase.angle)
            smooth = self._progress(abs(angle) / phase.speed, dt)
            axis = np.array((0.0, 0.0, 1.0)) if phase.about == "z" else rotation[:, 0]
            hands.rotation = rotation_from_vector(smooth * angle * axis).dot(rotation)
            return self._share >= 1.0
        way = np.array((0.0, 0.0, phase.height))
        if phase.do == "move":
            way = _heading(rotation).dot(phase.by)
        smooth = self._progress(float(np.linalg.norm(way)) / phase.speed, dt)
        hands.position = position + smooth * way
        if phase.do == "lift":
            hands.lifting = max(lifting, smooth * 0.5 * panel.body.mass * GRAVITY)
        return self._share >= 1.0

    def _progress(self, duration: float, dt: float) -> float:
        """How far [0, 1] a movement of a duration [s] has got, gently at both ends; it waits while it is hard."""
        if not self._hard():
            self._share = min(1.0, self._share + dt / max(duration, dt))
        return self._share * self._share * (3.0 - 2.0 * self._share)

    def _hard(self) -> bool:
        force, torque = self.hands.strain
        return force > ENOUGH_FORCE or torque > ENOUGH_TORQUE

    def _lower(self, phase: Phase, panel: Panel, dt: float) -> bool:
        """Down until the own end stands on the ground; then leave the weight to it, and level the other end."""
        hands, body = self.hands, panel.body
        far = body.position + panel.half[0] * body.rotation[:, 0]
        lowest = far[2] - float(np.abs(body.rotation[2, 1:]).dot(panel.half[1:]))
        force, torque = hands.strain
        higher = -2.0 * panel.half[0] * float(body.rotation[2, 0])
        if lowest > TOUCHING:
            if force < ENOUGH_FORCE and higher < WAITING:
                hands.position = hands.position - np.array((0.0, 0.0, phase.speed * dt))
        else:
            hands.lifting = max(0.0, hands.lifting - 0.5 * body.mass * GRAVITY * dt / RELAXING)
        if higher > HIGHER and torque < ENOUGH_TORQUE:
            along = body.rotation[:, 0]
            level = np.array((-along[1], along[0], 0.0)) / max(math.hypot(along[0], along[1]), 1e-6)
            hands.rotation = rotation_from_vector(-LEVELLING * dt * level).dot(hands.rotation)
        return lowest <= TOUCHING and hands.lifting == 0.0 and higher <= HIGHER

    def _follow(self, panel: Panel, target: Array, dt: float) -> None:
        hands = self.hands
        if not hands.holding:
            hands.take_hold(panel)
        hands.lifting = min(
            0.5 * panel.body.mass * GRAVITY, hands.lifting + 0.5 * panel.body.mass * GRAVITY * dt / RELAXING
        )
        way = target - hands.position
        distance = float(np.linalg.norm(way))
        if distance > 0.0 and not self._hard():
            hands.position = hands.position + way * min(1.0, GUIDED_SPEED * dt / distance)


def _heading(rotation: Array) -> Array:
    """Axes (3, 3) forwards along the panel, to the left and up, of a panel with a rotation (3, 3)."""
    x, y = float(rotation[0, 0]), float(rotation[1, 0])
    size = max(math.hypot(x, y), 1e-6)
    forwards = np.array((x / size, y / size, 0.0))
    return np.column_stack((forwards, (-forwards[1], forwards[0], 0.0), (0.0, 0.0, 1.0)))
