"""The way to the grasp: feeling that the tool is free, finding the marker, going there, closing the gripper."""

from __future__ import annotations

import numpy as np

from services.task.geometry import Pose, outside, steep
from services.task.grasp import GraspWatch, grasp_doubts
from services.task.parameters import TaskParameters
from services.task.states import Decision, Observation, State
from services.task.timers import Sustained
from shared.spatial import Array

_STILL = 0.02  # [m/s, rad/s] below which the tool is at rest
_FREE_AFTER = 0.5  # [s] at rest and without a force
_SWEEP_EVERY = 2.0  # [s] for which the head looks each way
_PAN, _TILT = (-1.309, 1.309), (-1.047, 0.785)  # [rad] as far as the head goes
_UNSEEN = ("marker_missing", "marker_edges")  # doubts that an arm before the camera may cause
_OUT_OF_SIGHT, _OUT_OF_SIGHT_ANGLE = (0.03, 0.1)  # [m], [rad] from the lookout pose, where the arm hides nothing
_ALIGNED, _ALIGNED_ANGLE = 0.02, 0.1  # [m], [rad] off the line to the grasp at which the tool may go in
_ASTRAY = 0.05  # [m] off that line from which the tool goes back and begins anew: the panel was moved
_TURNED_MUCH = 0.5
"""Angle [rad] by which a gripper of 0.8 kg has to turn to make a tare wrong by what the torque limits allow."""
_TOUCHED_AFTER = 0.3  # [s] of a force: somebody who bumps into the arm is gone by then
_ASTRAY_CAUSES = (
    "is something in the way, or is the panel elsewhere than the marker says: marker_size, grasp_position, the "
    "camera's place in base?"
)
_LAG = 0.1  # [m] of the target ahead of the tool: waiting longer presses no harder on what is in the way
_THERE, _THERE_ANGLE = 0.01, 0.05  # [m], [rad] from the grasp


class Approach:
    """One attempt at a grasp, from the first look until the gripper is closed on the panel."""

    def __init__(self, parameters: TaskParameters, tool: Pose) -> None:
        self._settings = parameters
        self._rest = tool
        self._offset = Pose.from_rpy(parameters.grasp_position, parameters.grasp_rpy)
        self._lookout = Pose.from_rpy(parameters.lookout_position, parameters.lookout_rpy)
        self._free = Sustained(_FREE_AFTER)
        self._watch = GraspWatch()
        self._head = (parameters.head_pan, parameters.head_tilt)
        self._way = 0.0
        self._touch = Sustained(_TOUCHED_AFTER)
        self._untouched: Array | None = None
        self._time = self._total = 0.0

    def enter(self, tool: Pose) -> None:
        """Begin another state, with the tool at this pose."""
        self._rest, self._time = tool, 0.0

    def calibrate(self, seen: Observation, dt: float) -> Decision:
        """Wait until the compensated wrench says that nothing touches the tool."""
        limit = self._settings.free_force
        force = 0.0 if seen.wrench is None else float(np.linalg.norm(seen.wrench[:3]))
        still = max(seen.speed, seen.turning) < _STILL
        head = (self._settings.head_pan, self._settings.head_tilt)
        if self._free.update(still and force < limit, dt):
            return Decision("looking for the marker", self._rest, head=head, after=State.SEARCHING)
        reason = "feeling whether the tool is free"
        if force >= limit:
            reason = f"{force:.1f} N on a free tool, allowed are {limit:g} N: let go of it, or `tandem tare`"
        return Decision(reason, self._rest, head=head)

    def search(self, seen: Observation, dt: float) -> Decision:
        """Look for a marker within reach, and at it from several sides.

        If the head has seen none all around, take the arm out of its view.
        """
        settings = self._settings
        self._pass(dt)
        pans = (0.0, settings.head_sweep, 0.0, -settings.head_sweep)
        if seen.turn is None:
            self._head = settings.head_pan + pans[int(self._time / _SWEEP_EVERY) % len(pans)], settings.head_tilt
        head = self._looking(seen)
        reason = seen.doubt.sentence if seen.doubt else "looking for the marker"
        if seen.doubt is not None and seen.doubt.name == "camera_wrong":
            return Decision(reason, self._rest, head=head, after=State.HOLDING)
        if seen.marker is None or not seen.proven:
            hides = not seen.tool.near(self._lookout, _OUT_OF_SIGHT, _OUT_OF_SIGHT_ANGLE)
            unseen = seen.doubt is None or seen.doubt.name in _UNSEEN
            if unseen and seen.turn is None and hides and self._time > len(pans) * _SWEEP_EVERY:
                self._rest = self._lookout
                reason = f"{reason} (the arm may hide it: it goes to the lookout pose)"
        elif problem := self._ungraspable(seen.marker @ self._offset):
            reason = problem
        else:
            self._way = 0.0
            return Decision("going to the panel", self._rest, head=head, after=State.APPROACHING)
        if self._time > settings.search_patience or self._exhausted:
            return Decision(f"gave up searching: {reason}", self._rest, after=State.HOLDING)
        return Decision(reason, self._rest, head=head)

    def approach(self, seen: Observation, dt: float) -> Decision:
        """Go to a point before the grasp, then straight in along the tool's x axis, by a fresh marker pose only."""
        settings = self._settings
        assert seen.marker is not None, "approaching without a fresh marker pose"
        self._pass(dt)
        grasp, head = seen.marker @ self._offset, self._looking(seen)
        problem = self._ungraspable(grasp)
        if problem or not seen.proven:
            after = State.HOLDING if self._exhausted else State.SEARCHING
            return Decision(problem or "the panel was moved: looking at it anew", seen.tool, head=head, after=after)
        ahead = grasp.rotation.T @ (grasp.position - seen.tool.position)
        sideways, angle = float(np.linalg.norm(ahead[1:])), grasp.angle(seen.tool)
        left = settings.standoff - self._way
        if sideways > _ASTRAY and self._way > 0.0:
            self._way = 0.0
        elif sideways < _ALIGNED and angle < _ALIGNED_ANGLE and ahead[0] - left < _LAG:
            # Not before it is at the point before the grasp; then no farther ahead than it follows.
            self._way = min(settings.standoff, self._way + settings.approach_speed * dt)
        target = grasp.shifted(self._way - settings.standoff)
        there = self._way >= settings.standoff and seen.tool.near(grasp, _THERE, _THERE_ANGLE)
        if there and max(seen.speed, seen.turning) < _STILL:
            return Decision("closing the gripper", seen.tool, after=State.GRASPING)
        if self._time > settings.move_patience:
            text = f"the grasp was not reached in {settings.move_patience:g} s: {np.linalg.norm(ahead):.2f} m and "
            why = "is something in the way?"
            if angle > _TURNED_MUCH:
                why += " Or does the tare not hold for a gripper that is turned so far? `tandem identify` weighs it"
            return Decision(f"{text}{angle:.2f} rad are left; {why}", seen.tool, after=State.HOLDING)
        if touched := self._touched(seen, dt):
            allowed = f"allowed are {settings.free_force:g} N"
            what = f"{touched:.1f} N, {allowed}, {np.linalg.norm(ahead):.2f} m before the grasp"
            reason = f"touched something where nothing should be ({what}): {_ASTRAY_CAUSES}"
            return Decision(reason, seen.tool, after=State.HOLDING)
        where = "going in" if self._way > 0.0 else "going to the point before the grasp"
        return Decision(f"{where}, {np.linalg.norm(ahead):.2f} m left", target, head=head)

    def grasp(self, seen: Observation, dt: float) -> Decision:
        """Close the gripper; carrying begins a second after its width, effort and word agree (carry 4)."""
        self._time += dt
        reasons = grasp_doubts(seen.gripper, self._settings)
        if self._watch.settled(reasons, dt):
            return Decision("lift the panel", seen.tool, after=State.CARRYING)
        if reasons and self._time > self._settings.grasp_patience:
            failed = f"the grasp failed: {', '.join(reasons)}; {_ASTRAY_CAUSES}"
            return Decision(failed, self._rest, after=State.HOLDING)
        return Decision(f"closing the gripper: {', '.join(reasons) or 'it holds'}", self._rest)

    def _ungraspable(self, grasp: Pose) -> str:
        """Why the tool cannot get to a grasp, or a panel not be carried from there; empty if all is well."""
        settings = self._settings
        if far := outside(grasp.position, settings.reach_low, settings.reach_high):
            told = f"its black square measures {settings.marker_size:g} m and grasp_position is as told"
            return f"the panel's grip is out of reach: {far}; move the panel or the robot, if {told}"
        if tilted := steep(grasp):
            return f"the panel lies too steep: {tilted}; lay it flatter, or tell how the marker is turned (grasp_rpy)"
        if grasp.rotation[0, 0] < 0.0:
            return "the panel's grip is on its far side: turn the panel, or tell how the marker is turned (grasp_rpy)"
        return ""

    def _touched(self, seen: Observation, dt: float) -> float:
        """The force [N] that has come up for long enough since the tool began to go in; 0 without."""
        if self._way == 0.0 or self._untouched is None:
            self._untouched = seen.wrench
        if seen.wrench is None or self._untouched is None:
            return 0.0
        # The weight of a gripper that was tared in another attitude is the same all the way in.
        force = float(np.linalg.norm((seen.wrench - self._untouched)[:3]))
        return force if self._touch.update(force > self._settings.free_force, dt) else 0.0

    def _looking(self, seen: Observation) -> tuple[float, float]:
        """Pan and tilt [rad] for where the head looks, and what the camera's proof wants of it besides."""
        pan, tilt = seen.turn or (0.0, 0.0)
        (left, right), (down, up) = _PAN, _TILT
        pan, tilt = self._head[0] + pan + seen.nudge, self._head[1] + tilt
        return min(right, max(left, pan)), min(up, max(down, tilt))

    def _pass(self, dt: float) -> None:
        self._time += dt
        self._total += dt

    @property
    def _exhausted(self) -> bool:
        """Whether searching and approaching have taken turns for longer than each may take."""
        return self._total > self._settings.search_patience + self._settings.move_patience
