"""The robot and simple shapes in a renderer on the processor: what the head camera sees."""

from __future__ import annotations

import weakref
from collections.abc import Mapping, Sequence

import numpy as np
import pybullet
from numpy.typing import NDArray

from shared.robot.tiago import URDF
from shared.spatial import Array, quaternion

Picture = NDArray[np.uint8]
Mask = NDArray[np.bool_]
Colour = tuple[float, float, float, float]
Matrix = tuple[float, ...]
"""Of the renderer: 16 numbers, column by column."""

_AWAY = (0.0, 0.0, -10.0)
_FLAT = (0.0, 0.0, 0.0, 1.0)


class Canvas:
    """A world of its own with the robot in it.

    Args:
        light: where it comes from.
        ambient, diffuse, specular: shares [1] of the light.
    """

    def __init__(self, light: Sequence[float], ambient: float, diffuse: float, specular: float) -> None:
        self._client = pybullet.connect(pybullet.DIRECT)
        # The engine's memory is not Python's: nobody gives it back for a canvas that is no more.
        self._release = weakref.finalize(self, pybullet.disconnect, self._client)
        self.on = {"physicsClientId": self._client}
        self._light = {
            "lightDirection": light,
            "lightColor": (1, 1, 1),
            "lightAmbientCoeff": ambient,
            "lightDiffuseCoeff": diffuse,
            "lightSpecularCoeff": specular,
        }
        self._robot = pybullet.loadURDF(str(URDF), useFixedBase=True, **self.on)
        info = [
            pybullet.getJointInfo(self._robot, joint, **self.on)
            for joint in range(pybullet.getNumJoints(self._robot, **self.on))
        ]
        self._joints = {entry[1].decode(): entry[0] for entry in info}

    def box(self, size: Sequence[float], colour: Colour) -> int:
        """A box of that size (3,) [m], out of sight until it is placed."""
        return self.shape(pybullet.GEOM_BOX, colour, halfExtents=[0.5 * side for side in size])

    def shape(self, kind: int, colour: Colour, **size: object) -> int:
        """A shape of one of the engine's kinds, out of sight until it is placed."""
        visual = pybullet.createVisualShape(kind, rgbaColor=colour, **size, **self.on)
        return pybullet.createMultiBody(0, -1, visual, _AWAY, **self.on)

    def place(self, body: int, position: Sequence[float] | Array, rotation: Array | None = None) -> None:
        """Put a shape at a position (3,) [m], turned by a rotation (3, 3)."""
        turned = _FLAT if rotation is None else quaternion(rotation).tolist()
        pybullet.resetBasePositionAndOrientation(body, [float(x) for x in position], turned, **self.on)

    def hide(self, body: int) -> None:
        """Put a shape out of sight."""
        pybullet.resetBasePositionAndOrientation(body, _AWAY, _FLAT, **self.on)

    def pose(self, joints: Mapping[str, float]) -> None:
        """Put the robot's joints at their positions [m, rad]; names that it does not have are passed over."""
        for name, position in joints.items():
            if name in self._joints:
                pybullet.resetJointState(self._robot, self._joints[name], position, **self.on)

    def render(self, width: int, height: int, view: Matrix, projection: Matrix) -> tuple[Picture, Mask]:
        """The picture (height, width, 3) in red, green, blue, and where nothing is in it (height, width)."""
        _, _, pixels, depth, _ = pybullet.getCameraImage(
            width,
            height,
            view,
            projection,
            **self._light,
            shadow=0,
            renderer=pybullet.ER_TINY_RENDERER,
            flags=pybullet.ER_NO_SEGMENTATION_MASK,
            **self.on,
        )
        picture = np.array(pixels, dtype=np.uint8).reshape(height, width, 4)[:, :, :3]
        return picture, np.reshape(depth, (height, width)) >= 1.0

    def close(self) -> None:
        """Release it."""
        self._release()
