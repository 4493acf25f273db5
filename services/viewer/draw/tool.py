"""What acts on the tool: the wrench as arrows, the limits in force as a box around the nominal one.

All of it stands at the tool's origin in base axes, a force of 1 N being ``PER_NEWTON`` long. The arrow ends where the
force is in the box; at a face the limit of that axis is used up, but for the error bound.
"""

from __future__ import annotations

import numpy as np
import rerun as rr

from services.viewer.draw.colours import AMBER, GREEN, PURPLE, RED, TEAL, YELLOW
from services.viewer.draw.robot import BASE, at, axes
from services.viewer.sample import Newest, Sample
from services.viewer.sentence import used, used_share
from shared.messages import ControlStatus, ControlTarget, EndEffector, ExternalWrench

TOOL = f"{BASE}/tool"
"""At the tool's origin, in base axes."""
WRENCH, LIMITS, ACTIVE = f"{TOOL}/wrench", f"{TOOL}/limits", f"{TOOL}/active"
POSE, GHOST = f"{BASE}/axes", f"{BASE}/target"
PER_NEWTON, PER_NEWTON_METRE = 0.015, 0.15
"""Length [m] of an arrow for 1 N and 1 Nm."""
NEAR = 0.75
"""Share [1] of a limit from which it counts as near: a quarter is left."""
_THIN = 0.002  # [m] thickness of a face
_HAND = (0.16, 0.1, 0.05)  # [m] about the size of a closed gripper, for the target's ghost


def style(rec: rr.RecordingStream) -> None:
    """What stays as it is; where things are is never among it, since what is static cannot be taken away."""
    rec.log(f"{WRENCH}/force", rr.Arrows3D.from_fields(colors=[YELLOW], radii=[0.009]), static=True)
    rec.log(f"{WRENCH}/torque", rr.Arrows3D.from_fields(colors=[PURPLE], radii=[0.006]), static=True)
    box = rr.Boxes3D.from_fields(fill_mode="majorwireframe", radii=[0.0025])
    rec.log(LIMITS, box, static=True)
    faces = rr.Boxes3D.from_fields(fill_mode="solid", colors=[(*RED, 150)])
    rec.log(f"{ACTIVE}/faces", faces, static=True)
    rec.log(f"{ACTIVE}/names", rr.Points3D.from_fields(colors=[RED], radii=[0.004], show_labels=True), static=True)
    ghost = rr.Boxes3D.from_fields(colors=[(*TEAL, 90)], fill_mode="transparentfillmajorwireframe")
    rec.log(f"{GHOST}/hand", ghost, static=True)


def pose(rec: rr.RecordingStream, sample: Sample[EndEffector], newest: Newest) -> None:
    """Where the tool is."""
    message = sample.message
    rec.log(TOOL, rr.Transform3D(translation=message.position))
    rec.log(POSE, at(message.position, message.orientation), axes(0.08))


def wrench(rec: rr.RecordingStream, sample: Sample[ExternalWrench], newest: Newest) -> None:
    """What the environment exerts on the tool."""
    message = sample.message
    rec.log(f"{WRENCH}/force", rr.Arrows3D.from_fields(vectors=[message.force * PER_NEWTON]))
    rec.log(f"{WRENCH}/torque", rr.Arrows3D.from_fields(vectors=[message.torque * PER_NEWTON_METRE]))


def limits(rec: rr.RecordingStream, sample: Sample[ControlStatus], newest: Newest) -> None:
    """The limits in force, and which of them is active, with its name."""
    status = sample.message
    if status.limit is None or status.nominal is None or not status.limit[:3].any():
        rec.log(LIMITS, rr.Clear(recursive=False))
        rec.log(ACTIVE, rr.Clear(recursive=True))
        return
    centre, half = status.nominal[:3] * PER_NEWTON, status.limit[:3] * PER_NEWTON
    active, share = np.flatnonzero(status.active), np.nan_to_num(used_share(status))
    colour = RED if active.size else AMBER if share.max() >= NEAR else GREEN
    rec.log(LIMITS, rr.Boxes3D.from_fields(centers=[centre], half_sizes=[half], colors=[colour]))
    if not active.size:
        rec.log(ACTIVE, rr.Clear(recursive=True))
        return
    middles, sizes = zip(*(_face(centre, half, int(axis), float(status.active[axis])) for axis in active), strict=True)
    rec.log(f"{ACTIVE}/faces", rr.Boxes3D.from_fields(centers=middles, half_sizes=sizes))
    names = [used(status, int(axis)) for axis in active]
    rec.log(f"{ACTIVE}/names", rr.Points3D.from_fields(positions=middles, labels=names))


def _face(centre: np.ndarray, half: np.ndarray, axis: int, side: float) -> tuple[np.ndarray, np.ndarray]:
    """Middle and half size [m] of a face of the box; a torque has none, its name stands at the tool."""
    if axis >= 3:
        return np.zeros(3), np.full(3, _THIN)
    middle, size = centre.copy(), half.copy()
    middle[axis] += side * half[axis]
    size[axis] = _THIN
    return middle, size


def target(rec: rr.RecordingStream, sample: Sample[ControlTarget], newest: Newest) -> None:
    """Where the tool is wanted."""
    message = sample.message
    rec.log(GHOST, at(message.position, message.orientation), axes(0.12))
    rec.log(f"{GHOST}/hand", rr.Boxes3D.from_fields(half_sizes=[np.array(_HAND) / 2.0]))
