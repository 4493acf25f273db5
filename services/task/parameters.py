"""Parameters of the carrying task; the defaults are the carry of ``docs/task.md``."""

from __future__ import annotations

import math
from typing import Literal

from services.task.geometry import QUARTER
from shared.parameters import Parameters, Refused, Vector3, option, parameter
from shared.spatial import GRAVITY

SAME_IN_A_MIRROR = (8, 9, 17, 47)
"""Numbers of DICT_4X4_50 that read the same in a mirrored picture, in which nothing is where it seems to be."""


class TaskParameters(Parameters):
    """What is carried, how it is found and grasped, within which limits, and how long to wait for what is missing."""

    marker_id: int = parameter(7, "", 0, 49, "number of the marker, DICT_4X4_50")
    marker_size: float = parameter(0.15, "m", 0.02, 1.0, "side of the marker's printed black square")
    marker_error: float = parameter(0.5, "px", 0.01, 10.0, "largest reprojection error (rms) of its corners")
    marker_accuracy: float = parameter(
        0.1, "px", 0.01, 2.0, "standard deviation to which a coordinate of a corner is measured"
    )
    head_accuracy: float = parameter(
        3e-4, "rad", 0.0, 0.02, "standard deviation to which the head's joints know where the camera looks, at best"
    )
    marker_jump: float = parameter(0.05, "m", 1e-3, 1.0, "largest step between two accepted images")
    marker_jump_angle: float = parameter(0.2, "rad", 1e-3, 3.0, "largest turn between two accepted images")
    marker_max_age: float = parameter(0.5, "s", 0.05, 2.0, "age of an image up to which its pose is used")
    marker_confirm: int = parameter(3, "images", 1, 100, "that have to agree at first")
    grasp_position: Vector3 = parameter(
        (0.0, -0.25, -0.025), "m", -2.0, 2.0, "tool origin in marker axes (x right, y up on the print, z out of it)"
    )
    grasp_rpy: Vector3 = parameter(
        (-QUARTER, 0.0, QUARTER),
        "rad",
        -math.pi,
        math.pi,
        "roll, pitch, yaw of the tool in marker axes; roll 90 degrees: TIAGo's fingers open along tool y",
    )
    reach_low: Vector3 = parameter((0.35, -0.7, 0.3), "m", -2.0, 2.0, "least tool position for a grasp, in base")
    reach_high: Vector3 = parameter((0.75, 0.2, 1.2), "m", -2.0, 2.0, "greatest tool position for a grasp")
    reach_down: float = parameter(
        0.27, "m", -1.0, 2.0, "least height of the tool in base at which the turned panel can be set down"
    )
    lookout_position: Vector3 = parameter(
        (0.45, -0.39, 0.78), "m", -2.0, 2.0, "tool in base where the arm does not hide the panel from the camera"
    )
    lookout_rpy: Vector3 = parameter(
        (-QUARTER, 0.0, 0.0), "rad", -math.pi, math.pi, "roll, pitch, yaw of the tool there"
    )
    standoff: float = parameter(0.15, "m", 0.02, 0.5, "way to the grasp, and back, along tool x")
    approach_speed: float = parameter(0.05, "m/s", 0.005, 0.25, "of the target on its last way to the grasp")
    panel_length: float = parameter(1.2, "m", 0.2, 3.0, "L, from the tool to the person's hands")
    panel_width: float = parameter(0.6, "m", 0.1, 2.0, "height of the panel when it stands turned on the ground")
    panel_thickness: float = parameter(0.05, "m", 0.002, 0.1, "between the fingers")
    panel_mass: float = parameter(1.5, "kg", 0.05, 10.0, "m; the robot carries half")
    ground_height: float = parameter(0.0, "m", -0.5, 1.0, "of the ground under the panel, in base, to 4 cm")
    gripper_open: float = parameter(0.085, "m", 0.0, 0.2, "opening before and after")
    gripper_effort: float = parameter(16.0, "N", 0.5, 100.0, "of closing")
    grasp_effort: float = parameter(3.0, "N", 0.0, 100.0, "effort that a verified grasp shows at least")
    grip_torque: float = parameter(
        10.0, "Nm", 0.1, 1000.0, "largest moment of the panel's weight that the gripper holds alone; simulated: 12"
    )
    grasp_width: float = parameter(
        0.02, "m", 1e-3, 0.1, "largest difference of opening and panel_thickness: foam and fingers give way"
    )
    compensation: Literal["tare", "payload"] = option(
        "tare", "least compensation of the wrench; turning by 90 degrees wants payload"
    )
    free_force: float = parameter(3.0, "N", 0.1, 50.0, "largest force on a tool that touches nothing, after a tare")
    force_limit: Vector3 = parameter((10.0,) * 3, "N", 0.1, 200.0, "on x, y, z")
    torque_limit: Vector3 = parameter((0.5, 3.0, 3.0), "Nm", 0.05, 50.0, "about x, y, z")
    fixed_target: bool = option(
        False, "the whole pose of the grasp stays the target, as in the paper: for the law paper"
    )
    level_assist: float = parameter(1.0, "1", 0.0, 1.0, "share of the level assist; 0 = off: the height of the grasp")
    level_compliance: float = parameter(0.01, "rad/Nm", 0.0, 0.1, "tilt that a newton metre across the panel counts as")
    release_ramp: bool = option(
        True, "the nominal wrench fades while the panel is set down; off, a heavy one is never released"
    )
    head_pan: float = parameter(-0.35, "rad", -1.309, 1.309, "looking at the panel")
    head_tilt: float = parameter(-0.6, "rad", -1.047, 0.785, "looking at the panel")
    head_sweep: float = parameter(0.35, "rad", 0.0, 1.0, "pan to either side while nothing is seen")
    patience: float = parameter(3.0, "s", 0.0, 60.0, "wait for wrench, controller or tool pose before holding")
    marker_patience: float = parameter(5.0, "s", 0.0, 60.0, "wait for a covered marker before holding")
    search_patience: float = parameter(60.0, "s", 1.0, 3600.0, "search for the marker before holding")
    move_patience: float = parameter(60.0, "s", 5.0, 600.0, "longest approach or retreat before holding")
    grasp_patience: float = parameter(6.0, "s", 2.0, 60.0, "for the gripper to close or open as wanted, before holding")
    resume_distance: float = parameter(
        0.2, "m", 0.0, 1.0, "from the last target up to which a restart goes on carrying"
    )
    resume_angle: float = parameter(
        0.5, "rad", 0.0, 3.0, "turn from the last target up to which a restart goes on carrying"
    )
    journal_max_age: float = parameter(120.0, "s", 1.0, 86400.0, "of a journal that a restart goes by")
    max_delay: float = parameter(0.1, "s", 1e-3, 1.0, "bound on how much later than the fastest one a pose may arrive")

    def check(self) -> None:
        """Refuse a gripper that cannot open wider than the panel, and a marker that does not show a mirrored picture.

        Raises:
            Refused: with what is allowed.
        """
        if self.marker_id in SAME_IN_A_MIRROR:
            raise Refused(
                f"marker_id is {self.marker_id}, which reads the same in a mirrored picture, as do "
                f"{', '.join(map(str, SAME_IN_A_MIRROR))}: print another one"
            )
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
        """Why the panel could never be set down (carry 3); empty if it can."""
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
