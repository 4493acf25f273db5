"""From the lift to the retreat: target, nominal wrench and release of a panel that is held."""

from __future__ import annotations

from services.task.fingers import Fingers
from services.task.geometry import Pose, roll_since
from services.task.level_assist import LevelAssist, far_end_drop
from services.task.nominal_wrench import NominalWrench
from services.task.parameters import TaskParameters
from services.task.release import RELEASE_FORCE, ReleaseJudge, Stance, why_no_probe, why_no_release
from services.task.states import Decision, Observation, State
from services.task.target import carrying_target, standing_target
from services.task.timers import Sustained

_BACK = 0.03  # [m] from the end of the way back at which it is finished
_BEYOND = 1.2  # [1] of the limit along z from which an arm that stands does not yield as it should
_STANDS = 0.005  # [m/s] below which the arm stands
_STUCK_AFTER = 1.0  # [s] of both


class Carry:
    """One carry.

    Args:
        parameters: of the task.
        fingers: that hold the panel.
        home: the tool when the grasp was finished; its x, y and yaw are the target's.
        height: of the target at first [m].
        nominal: what the robot carries already.
    """

    def __init__(
        self,
        parameters: TaskParameters,
        fingers: Fingers,
        home: Pose,
        height: float,
        nominal: NominalWrench | None = None,
    ) -> None:
        self._settings = parameters
        self._fingers = fingers
        self.home = home
        self.nominal = nominal or NominalWrench(parameters.half_weight)
        self._level = LevelAssist(parameters.level_assist, height)
        self._judge = ReleaseJudge()
        self._standing = Sustained(_STUCK_AFTER)
        self.asked = False
        """A person said that the panel is to be let go where it is."""
        self.letting_go = False
        """The gripper opens, or has: nothing holds the panel any more."""
        self._time = 0.0
        self._end: Pose | None = None
        self._place: Pose | None = None

    def carry(self, seen: Observation, dt: float) -> Decision:
        """Follow the person: target (carry 1), its height (carry 2) and nominal wrench (carry 3)."""
        settings = self._settings
        self._place = None
        height = self._height(seen, dt)
        target = carrying_target(self.home, seen.tool, height, settings.fixed_target)
        force = self.nominal.carry(seen.force, dt)
        stance = self._stance(seen)
        probe = self._judge.may_probe(stance, dt)
        if self.nominal.supported and probe:
            return Decision("setting the panel down", target, force, after=State.RELEASING)
        if not self.nominal.supported:
            carried = f"the robot carries {max(0.0, -seen.force):.1f} of {settings.half_weight:.1f} N"
            reason = f"lift the panel: {carried}"
        else:
            missing = ", ".join(why_no_probe(stance)) or "about to stand"
            reason = f"carrying; to be set down: {missing}{self._stuck(seen, dt)}"
        return Decision(f"{reason}{settings.warning}", target, force, base=True)

    def release(self, seen: Observation, dt: float) -> Decision:
        """Set the panel down gently until the ground carries it, then open (carry 5)."""
        if self.letting_go:
            return self._open(seen, dt)
        settings = self._settings
        force = self.nominal.fade(dt) if settings.release_ramp else self.nominal.force
        stance = self._stance(seen)
        if self._judge.may_release(stance, dt, pose_matters=not self.asked):
            return self.let_go(seen)
        target = self._set_down(seen.tool)
        if not self.asked and self._judge.has_to_leave(stance):
            self._level.height = float(seen.tool.position[2])
            missing = ", ".join(why_no_probe(stance))
            return Decision(f"carrying on: {missing}", target, force, after=State.CARRYING)
        missing_now = why_no_release(stance, self._judge.force)
        if self.asked:
            allowed, now = f"less than {-RELEASE_FORCE:g} N", f"{max(0.0, -self._judge.force):.1f} N"
            reason = f"letting go as asked once the robot carries {allowed}, now {now}; `release` again opens at once"
        else:
            reason = f"setting down: {', '.join(missing_now) or 'it stands'}{self._stuck(seen, dt)}"
        return Decision(reason, target, force)

    def let_go(self, seen: Observation) -> Decision:
        """Open the gripper from now on."""
        self.letting_go, self._end, self._time = True, seen.tool, 0.0
        self._fingers.open()
        return Decision("opening the gripper", seen.tool)

    def _open(self, seen: Observation, dt: float) -> Decision:
        self._time += dt
        if self._fingers.opened(seen.gripper, dt):
            assert self._end is not None
            self._end, self._time = self._end.shifted(-self._settings.standoff), 0.0
            return Decision("going back", seen.tool, after=State.RETREATING)
        if self._time > self._settings.grasp_patience:
            return Decision("the gripper does not open: look at it", seen.tool, after=State.HOLDING)
        return Decision("opening the gripper", self._end)

    def retreat(self, seen: Observation, dt: float) -> Decision:
        """Go straight back along the tool's x axis."""
        assert self._end is not None
        self._time += dt
        left = seen.tool.distance(self._end)
        if left < _BACK:
            return Decision("the panel was set down", self._end, after=State.DONE)
        if self._time > self._settings.move_patience:
            reason = f"the way back was not finished in {self._settings.move_patience:g} s"
            return Decision(f"{reason}, {left:.2f} m are left", seen.tool, after=State.HOLDING)
        return Decision(f"going back, {left:.2f} m left", self._end)

    def _set_down(self, tool: Pose) -> Pose:
        """The target while the panel is set down."""
        if self._settings.fixed_target:
            return self.home
        self._place = self._place or tool
        return standing_target(self._place, tool, float(tool.position[2]) - self._judge.press())

    def _stuck(self, seen: Observation, dt: float) -> str:
        """Words for an arm that stands under a force beyond the limit, as only its own limits explain; else empty."""
        settings = self._settings
        excess = abs(seen.force - self.nominal.force) - _BEYOND * settings.force_limit[2]
        if not self._standing.update(excess > 0.0 and seen.speed < _STANDS, dt):
            return ""
        return f"; the arm cannot give way any further ({seen.robot or 'the robot does not say why'})"

    def _height(self, seen: Observation, dt: float) -> float:
        settings = self._settings
        if settings.level_assist == 0.0 or seen.wrench is None:
            return float(self.home.position[2])
        offset = far_end_drop(seen.tool, seen.wrench[3:], settings.panel_length, settings.level_compliance)
        return self._level.update(float(seen.tool.position[2]), offset, dt)

    def _stance(self, seen: Observation) -> Stance:
        return Stance(
            roll=roll_since(self.home, seen.tool),
            pitch=float(seen.tool.rpy[1]),
            height=float(seen.tool.position[2]) - self._settings.standing_height,
            speed=seen.speed,
            turning=seen.turning,
            force=seen.force,
        )
