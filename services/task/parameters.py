"""Parameters of the carrying task; the defaults are the carry of ``docs/task.md``."""

from __future__ import annotations

import math
from typing import Literal

from services.task.geometry import QUARTER
from services.task.vision.marker_tracker import MarkerLimits
from shared.constants import GRAVITY
from shared.parameters import Parameters, Refused, Vector3, parameter


class TaskParameters(Parameters):
    """What is carried, how it is found and grasped, within which limits, and how long to wait for what is missing."""

    marker_id: int = parameter(7, unit="", minimum=0, maximum=49, doc="number of the marker, DICT_4X4_50")
    marker_size: float = parameter(
        0.15, unit="m", minimum=0.02, maximum=1.0, doc="side of the marker's printed black square"
    )
    marker_error: float = parameter(
        0.5, unit="px", minimum=0.01, maximum=10.0, doc="largest reprojection error (rms) of its corners"
    )
    marker_ambiguity: float = parameter(
        2.0, unit="1", minimum=1.0, maximum=100.0, doc="how many times worse the other tilt has to fit"
    )
    marker_jump: float = parameter(
        0.05, unit="m", minimum=1e-3, maximum=1.0, doc="largest step between two accepted images"
    )
    marker_jump_angle: float = parameter(
        0.2, unit="rad", minimum=1e-3, maximum=3.0, doc="largest turn between two accepted images"
    )
    marker_max_age: float = parameter(
        0.5, unit="s", minimum=0.05, maximum=2.0, doc="age of an image up to which its pose is used"
    )
    marker_confirm: int = parameter(
        3, unit="images", minimum=1, maximum=100, doc="that have to agree at first"
    )
    grasp_position: Vector3 = parameter(
        (0.0, -0.25, -0.025),
        unit="m",
        minimum=-2.0,
        maximum=2.0,
        doc="tool origin in marker axes (x right, y up on the print, z out of it)",
    )
    grasp_rpy: Vector3 = parameter(
        (-QUARTER, 0.0, QUARTER),
        unit="rad",
        minimum=-math.pi,
        maximum=math.pi,
        doc="roll, pitch, yaw of the tool in marker axes; roll 90 degrees: TIAGo's fingers open along tool y",
    )
    reach_low: Vector3 = parameter(
        (0.35, -0.7, 0.3), unit="m", minimum=-2.0, maximum=2.0, doc="least tool position for a grasp, in base"
    )
    reach_high: Vector3 = parameter(
        (0.75, 0.2, 1.2), unit="m", minimum=-2.0, maximum=2.0, doc="greatest tool position for a grasp"
    )
    reach_down: float = parameter(
        0.27,
        unit="m",
        minimum=-1.0,
        maximum=2.0,
        doc="least height of the tool in base at which the turned panel can be set down",
    )
    lookout_position: Vector3 = parameter(
        (0.45, -0.39, 0.78),
        unit="m",
        minimum=-2.0,
        maximum=2.0,
        doc="tool in base where the arm does not hide the panel from the camera",
    )
    lookout_rpy: Vector3 = parameter(
        (-QUARTER, 0.0, 0.0),
        unit="rad",
        minimum=-math.pi,
        maximum=math.pi,
        doc="roll, pitch, yaw of the tool there",
    )
    standoff: float = parameter(
        0.15, unit="m", minimum=0.02, maximum=0.5, doc="way to the grasp, and back, along tool x"
    )
    approach_speed: float = parameter(
        0.05, unit="m/s", minimum=0.005, maximum=0.25, doc="of the target on its last way to the grasp"
    )
    panel_length: float = parameter(
        1.2, unit="m", minimum=0.2, maximum=3.0, doc="L, from the tool to the person's hands"
    )
    panel_width: float = parameter(
        0.6, unit="m", minimum=0.1, maximum=2.0, doc="height of the panel when it stands turned on the ground"
    )
    panel_thickness: float = parameter(0.05, unit="m", minimum=0.002, maximum=0.1, doc="between the fingers")
    panel_mass: float = parameter(1.5, unit="kg", minimum=0.05, maximum=10.0, doc="m; the robot carries half")
    ground_height: float = parameter(
        0.0, unit="m", minimum=-0.5, maximum=1.0, doc="of the ground under the panel, in base, to 4 cm"
    )
    gripper_open: float = parameter(0.085, unit="m", minimum=0.0, maximum=0.2, doc="opening before and after")
    gripper_effort: float = parameter(16.0, unit="N", minimum=0.5, maximum=100.0, doc="of closing")
    grasp_effort: float = parameter(
        3.0, unit="N", minimum=0.0, maximum=100.0, doc="effort that a verified grasp shows at least"
    )
    grip_torque: float = parameter(
        10.0,
        unit="Nm",
        minimum=0.1,
        maximum=1000.0,
        doc="largest moment of the panel's weight that the gripper holds alone; simulated: 12",
    )
    grasp_width: float = parameter(
        0.02,
        unit="m",
        minimum=1e-3,
        maximum=0.1,
        doc="largest difference of opening and panel_thickness: foam and fingers give way",
    )
    compensation: Literal["tare", "payload"] = parameter(
        "tare", unit="", doc="least compensation of the wrench; turning by 90 degrees wants payload"
    )
    free_force: float = parameter(
        3.0,
        unit="N",
        minimum=0.1,
        maximum=50.0,
        doc="largest force on a tool that touches nothing, after a tare",
    )
    force_limit: Vector3 = parameter((10.0,) * 3, unit="N", minimum=0.1, maximum=200.0, doc="on x, y, z")
    torque_limit: Vector3 = parameter(
        (0.5, 3.0, 3.0), unit="Nm", minimum=0.05, maximum=50.0, doc="about x, y, z"
    )
    fixed_target: bool = parameter(
        False, unit="", doc="the whole pose of the grasp stays the target, as in the paper: for the law paper"
    )
    level_assist: float = parameter(
        1.0,
        unit="1",
        minimum=0.0,
        maximum=1.0,
        doc="share of the level assist; 0 = off: the height of the grasp",
    )
    level_compliance: float = parameter(
        0.01,
        unit="rad/Nm",
        minimum=0.0,
        maximum=0.1,
        doc="tilt that a newton metre across the panel counts as",
    )
    release_ramp: bool = parameter(
        True,
        unit="",
        doc="the nominal wrench fades while the panel is set down; off, a heavy one is never released",
    )
    head_pan: float = parameter(-0.35, unit="rad", minimum=-1.309, maximum=1.309, doc="looking at the panel")
    head_tilt: float = parameter(-0.6, unit="rad", minimum=-1.047, maximum=0.785, doc="looking at the panel")
    head_sweep: float = parameter(
        0.35, unit="rad", minimum=0.0, maximum=1.0, doc="pan to either side while nothing is seen"
    )
    patience: float = parameter(
        3.0,
        unit="s",
        minimum=0.0,
        maximum=60.0,
        doc="wait for wrench, controller or tool pose before holding",
    )
    marker_patience: float = parameter(
        5.0, unit="s", minimum=0.0, maximum=60.0, doc="wait for a covered marker before holding"
    )
    search_patience: float = parameter(
        60.0, unit="s", minimum=1.0, maximum=3600.0, doc="search for the marker before holding"
    )
    move_patience: float = parameter(
        60.0, unit="s", minimum=5.0, maximum=600.0, doc="longest approach or retreat before holding"
    )
    grasp_patience: float = parameter(
        6.0,
        unit="s",
        minimum=2.0,
        maximum=60.0,
        doc="for the gripper to close or open as wanted, before holding",
    )
    resume_distance: float = parameter(
        0.2,
        unit="m",
        minimum=0.0,
        maximum=1.0,
        doc="from the last target up to which a restart goes on carrying",
    )
    resume_angle: float = parameter(
        0.5, unit="rad", minimum=0.0, maximum=3.0, doc="the same for the attitude"
    )
    journal_max_age: float = parameter(
        120.0, unit="s", minimum=1.0, maximum=86400.0, doc="of a journal that a restart goes by"
    )
    max_delay: float = parameter(
        0.1,
        unit="s",
        minimum=1e-3,
        maximum=1.0,
        doc="bound on how much later than the fastest one a pose may arrive",
    )

    def check(self) -> None:
        """Refuse a gripper that cannot open wider than the panel.

        Raises:
            Refused: with both numbers.
        """
        if self.gripper_open < self.panel_thickness + self.grasp_width:
            raise Refused(
                f"gripper_open is {self.gripper_open} m, wanted at least panel_thickness + grasp_width = "
                f"{self.panel_thickness + self.grasp_width:g} m"
            )

    @property
    def half_weight(self) -> float:
        """M g / 2 [N], what the robot carries of the panel."""
        return self.panel_mass * GRAVITY / 2

    @property
    def warning(self) -> str:
        """What the person has to know about a panel that the gripper does not hold alone; empty if it does."""
        alone = self.half_weight * self.panel_length
        if alone <= self.grip_torque:
            return ""
        return f"; do not let go of the panel before it stands: its {alone:.0f} Nm would tear it out of the gripper"

    @property
    def standing_height(self) -> float:
        """Height [m] in base of the tool when the turned panel stands on the ground."""
        return self.ground_height + self.panel_width / 2

    def impossible(self) -> str:
        """Why the panel could never be set down (CARRY 3), empty if it can."""
        if self.standing_height < self.reach_down:
            return (
                f"the turned panel stands with the gripper at {self.standing_height:.2f} m, which is below reach_down, "
                f"{self.reach_down:g} m: carry one that is at least {2 * (self.reach_down - self.ground_height):.2f} m "
                "wide"
            )
        limit = self.force_limit[2]
        if self.release_ramp or self.half_weight <= limit:
            return ""
        return (
            f"half the panel's weight is {self.half_weight:.1f} N, above the force limit of {limit:g} N along z: "
            "it would never be released; set release_ramp, raise force_limit or carry less"
        )

    def marker_limits(self) -> MarkerLimits:
        """What the marker has to be like."""
        return MarkerLimits(
            number=self.marker_id,
            error=self.marker_error,
            ambiguity=self.marker_ambiguity,
            jump=self.marker_jump,
            jump_angle=self.marker_jump_angle,
            max_age=self.marker_max_age,
            confirm=self.marker_confirm,
        )
