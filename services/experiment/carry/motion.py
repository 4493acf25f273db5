"""What moved where in a carry: panel, hands, base and tool, all in world axes on the times of `sim/world`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from services.experiment.carry.carry_protocol import PANEL_SIZE
from services.experiment.measure.series import at, rate
from services.experiment.play.recording import Recording
from shared import topics

_HALF = np.array(PANEL_SIZE) / 2.0


@dataclass(frozen=True)
class Motion:
    """World axes are those of base_footprint at the start; the person holds the panel's +x end, the robot the other.

    Attributes:
        time: (n,) [s] of arrival.
        sampled: (n,) [s] by the simulation's own clock, free of delays on the way.
        doing: (n,) what the person is about.
        panel, panel_axes: its centre (n, 3) [m] and its axes as columns (n, 3, 3).
        hand: (n, 3) [m] where the person's hands are.
        wish, wish_axes: (n, 3) [m] where the person wants them, and (n, 3, 3) how the panel's axes are wanted; NaN
            before the person is asked to do anything.
        push, twist: (n, 3) [N] and (n, 3) [Nm] of the hands on the panel, about where they are.
        base: (n, 3) x, y [m] and yaw [rad] by odometry.
        tool, tool_axes: (n, 3) [m] and (n, 3, 3).
    """

    time: np.ndarray
    sampled: np.ndarray
    doing: np.ndarray
    panel: np.ndarray
    panel_axes: np.ndarray
    hand: np.ndarray
    wish: np.ndarray
    wish_axes: np.ndarray
    push: np.ndarray
    twist: np.ndarray
    base: np.ndarray
    tool: np.ndarray
    tool_axes: np.ndarray

    @classmethod
    def of(cls, recording: Recording) -> Motion:
        """What a recording says of it; KeyError names what it lacks."""
        world, odometry, arm = topics.SIM_WORLD.key, topics.STATE_BASE.key, topics.STATE_EE.key
        time = recording.time(world)
        driven = np.column_stack((recording.series(odometry, "position"), np.unwrap(recording.series(odometry, "yaw"))))
        base = at(time, recording.time(odometry), driven)
        heading = turns_about_z(base[:, 2])
        reached = at(time, recording.time(arm), recording.series(arm, "position"))
        attitude = rotations(recording.newest(arm, time, "orientation"))
        return cls(
            time=time,
            sampled=recording.series(world, "message_time"),
            doing=recording.series(world, "hand.doing"),
            panel=recording.series(world, "panel.position"),
            panel_axes=rotations(recording.series(world, "panel.orientation")),
            hand=recording.series(world, "hand.position"),
            wish=recording.series(world, "hand.wanted"),
            wish_axes=rotations(recording.series(world, "hand.wanted_orientation")),
            push=recording.series(world, "hand.force"),
            twist=recording.series(world, "hand.torque"),
            base=base,
            tool=turned(heading, reached) + base[:, :2] @ np.eye(2, 3),
            tool_axes=heading @ attitude,
        )

    @property
    def roll(self) -> np.ndarray:
        """How far (n,) [rad] the panel is turned about its long axis."""
        return np.unwrap(_roll(self.panel_axes))

    @property
    def wish_roll(self) -> np.ndarray:
        """How far (n,) [rad] the person wants the panel turned about its long axis."""
        ahead = _roll(self.wish_axes) - _roll(self.panel_axes)
        return self.roll + np.arctan2(np.sin(ahead), np.cos(ahead))

    @property
    def tool_roll(self) -> np.ndarray:
        """How far (n,) [rad] the tool is turned about the panel's long axis, up to a constant."""
        return np.unwrap(_roll(self.tool_axes))

    @property
    def tilt(self) -> np.ndarray:
        """How far (n,) [rad] the panel's long axis is off the horizontal, positive with the person's end up."""
        return np.arcsin(np.clip(self.panel_axes[:, 2, 0], -1.0, 1.0))

    @property
    def lowest(self) -> np.ndarray:
        """Height (n,) [m] of the panel's lowest corner above the ground."""
        return self.panel[:, 2] - np.abs(self.panel_axes[:, 2]) @ _HALF

    @property
    def ends(self) -> np.ndarray:
        """Middles of the panel's two ends (n, 2, 3) [m]: the robot's, the person's."""
        along = _HALF[0] * self.panel_axes[:, :, 0]
        return np.stack((self.panel - along, self.panel + along), axis=1)

    @property
    def twist_in_base(self) -> np.ndarray:
        """How the hands move in base axes, as a rigid body at the tool's origin: (n, 6) [m/s, rad/s].

        The base's own motion is in it with the opposite sign: a person who walks with the base does not move in it.
        """
        back = turns_about_z(self.base[:, 2]).transpose(0, 2, 1)
        planted = self.base[:, :2] @ np.eye(2, 3)
        hand, tool = turned(back, self.hand - planted), turned(back, self.tool - planted)
        axes = back @ self.panel_axes
        linear = rate(self.time, hand)
        angular = spin(self.time, axes)
        return np.hstack((linear + np.cross(angular, tool - hand), angular))


def rotations(quaternions: np.ndarray) -> np.ndarray:
    """Rotation matrices (n, 3, 3) of unit quaternions (n, 4), x y z w."""
    x, y, z, w = quaternions.T
    rows = (
        (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
        (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
        (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
    )
    return np.array(rows).transpose(2, 0, 1)


def turns_about_z(angles: np.ndarray) -> np.ndarray:
    """Rotation matrices (n, 3, 3) about z by angles (n,) [rad]."""
    half = angles / 2.0
    zero = np.zeros_like(half)
    return rotations(np.column_stack((zero, zero, np.sin(half), np.cos(half))))


def turned(rotation: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Vectors (n, 3), each by its rotation (n, 3, 3)."""
    return np.einsum("nij,nj->ni", rotation, vectors)


def spin(time: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Angular velocity (n, 3) [rad/s] of axes (n, 3, 3) as columns, in the axes that these are stated in."""
    turning = rate(time, axes.reshape(-1, 9)).reshape(-1, 3, 3) @ axes.transpose(0, 2, 1)
    # vee((dR/dt) R'); over SMOOTHING it is only nearly skew.
    return 0.5 * np.column_stack(
        (turning[:, 2, 1] - turning[:, 1, 2], turning[:, 0, 2] - turning[:, 2, 0], turning[:, 1, 0] - turning[:, 0, 1])
    )


def _roll(axes: np.ndarray) -> np.ndarray:
    return np.arctan2(axes[:, 2, 1], axes[:, 2, 2])
