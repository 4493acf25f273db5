"""The way to the grasp: feeling that the tool is free, finding the marker, going there, closing the gripper."""

from __future__ import annotations

import numpy as np

from services.task.geometry import Pose, outside, steep
from services.task.grasp import GraspWatch, grasp_doubts
from services.task.parameters import TaskParameters
from services.task.states import Decision, Observation, State
from services.task.timers import Sustained

_STILL = 0.02  # [m/s, rad/s] below which the tool is at rest
_FREE_AFTER = 0.5  # [s] at rest and without a force
_SWEEP_EVERY = 2.0  # [s] for which the head looks each way
_OUT_OF_SIGHT, _OUT_OF_SIGHT_ANGLE = (0.03, 0.1)  # [m], [rad] from the lookout pose, where the arm hides nothing
_ALIGNED, _ALIGNED_ANGLE = 0.02, 0.1  # [m], [rad] off the line to the grasp at which the tool may go in
_ASTRAY = 0.05  # [m] off that line from which the tool goes back and begins anew: the panel was moved
_TURNED_MUCH = 0.5
"""Angle [rad] by which a gripper of 0.8 kg has to turn to make a tare wrong by what the torque limits allow."""
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
        self._way = 0.0
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
        """Look for a marker within reach; if the head has seen none all around, take the arm out of its view."""
        settings = self._settings
        self._pass(dt)
        pans = (0.0, settings.head_sweep, 0.0, -settings.head_sweep)
        step = 0 if seen.marker is not None else int(self._time / _SWEEP_EVERY)
        pan = min(1.309, max(-1.309, settings.head_pan + pans[step % len(pans)]))
        head = (pan, settings.head_tilt)
        if seen.marker is None:
            reason = seen.doubt.sentence if seen.doubt else "looking for the marker"
            hides = not seen.tool.near(self._lookout, _OUT_OF_SIGHT, _OUT_OF_SIGHT_ANGLE)
            if hides and self._time > len(pans) * _SWEEP_EVERY:
                self._rest = self._lookout
                reason = f"{reason} (the arm may hide it: it goes to the lookout pose)"
        elif problem := self._ungraspable(seen.marker @ self._offset):
            reason = f"{problem}; move the panel or the robot"
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
        grasp = seen.marker @ self._offset
        if problem := self._ungraspable(grasp):
            after = State.HOLDING if self._exhausted else State.SEARCHING
            return Decision(f"the panel was moved: {problem}", seen.tool, after=after)
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
        where = "going in" if self._way > 0.0 else "going to the point before the grasp"
        return Decision(f"{where}, {np.linalg.norm(ahead):.2f} m left", target)

    def grasp(self, seen: Observation, dt: float) -> Decision:
        """Close the gripper; carrying begins a second after its width, effort and word agree (carry 4)."""
        self._time += dt
        reasons = grasp_doubts(seen.gripper, self._settings)
        if self._watch.settled(reasons, dt):
            return Decision("lift the panel", seen.tool, after=State.CARRYING)
        if reasons and self._time > self._settings.grasp_patience:
            return Decision(f"the grasp failed: {', '.join(reasons)}", self._rest, after=State.HOLDING)
        return Decision(f"closing the gripper: {', '.join(reasons) or 'it holds'}", self._rest)

    def _ungraspable(self, grasp: Pose) -> str:
        """Why the tool cannot get to a grasp, or a panel not be carried from there; empty if all is well."""
        if far := outside(grasp.position, self._settings.reach_low, self._settings.reach_high):
            return f"the panel's grip is out of reach: {far}"
        if tilted := steep(grasp):
            return f"the panel lies too steep: {tilted}"
        if grasp.rotation[0, 0] < 0.0:
            return "the panel's grip is on its far side"
        return ""

    def _pass(self, dt: float) -> None:
        self._time += dt
        self._total += dt

    @property
    def _exhausted(self) -> bool:
        """Whether searching and approaching have taken turns for longer than each may take."""
        return self._total > self._settings.search_patience + self._settings.move_patience
