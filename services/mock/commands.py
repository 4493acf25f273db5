"""Commands on their way to the hardware: here they are integrated, a bridge hands them to its motors."""

from __future__ import annotations

import math

import numpy as np

from services.mock.parameters import MockParameters
from shared.robot.side import RobotSide
from shared.robot.tiago import FINGER_TRAVEL
from shared.spatial import Array, rotation_from_vector


class Motors:
    """Tool, base and fingers are where their commands have led, at once and exactly.

    Attributes:
        position, rotation: of the tool in base (3,) [m], (3, 3).
        twist: that the gate lets through (6,) [m/s, rad/s], base axes; a ``still`` robot does not carry it out.
        base: x, y [m] and yaw [rad] of the base's odometry (3,).
        base_velocity: vx, vy [m/s], wz [rad/s] (3,), base axes.
        opening: distance [m] between the fingers.
    """

    def __init__(self, parameters: MockParameters) -> None:
        self.still = parameters.still
        self.position: Array = np.array(parameters.position)
        self.rotation: Array = np.eye(3)
        self.base: Array = np.zeros(3)
        self.opening = 2.0 * FINGER_TRAVEL
        self.twist: Array = np.zeros(6)
        self.base_velocity: Array = np.zeros(3)

    def carry_out(self, side: RobotSide, dt: float) -> None:
        """Move for ``dt`` [s] as the gate lets it.

        Fingers arrive at once and the head is seen by nobody. Where they take their time, a stop (``side.freeze``)
        halts them on their way.
        """
        if side.gripper is not None:
            self.opening = side.gripper.opening
        self.twist = side.advance(dt)
        self.base_velocity = side.advance_base(dt)
        if not self.still:
            self.position = self.position + dt * self.twist[:3]
            if self.twist[3:].any():
                self.rotation = rotation_from_vector(dt * self.twist[3:]) @ self.rotation
        vx, vy, wz = self.base_velocity.tolist()
        cosine, sine = math.cos(self.base[2]), math.sin(self.base[2])
        self.base = self.base + dt * np.array((cosine * vx - sine * vy, sine * vx + cosine * vy, wz))

    def stay(self) -> None:
        """Move no more until something else is carried out."""
        self.twist, self.base_velocity = np.zeros(6), np.zeros(3)
