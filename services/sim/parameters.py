"""The simulated robot's parameters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

from pydantic import model_validator

from services.sim.camera.view import Scenery
from services.sim.scene.hands import STIFFNESS
from services.sim.scene.panel import PanelSpec
from services.sim.scene.panel_scene import PanelSceneSpec
from shared.parameters import Parameters, Refused, Vector3, Vector6, option, parameter

SLOWEST_RATE = 30.0
"""Rate [Hz] in real time below which the contract's readers take a sensor for silent in between."""

BaseType = Literal["differential", "omni"]
SceneName = Literal["full", "load", "carry"]

_AHEAD_OF_THE_ARM = (0.57, -0.39, 0.78)
"""Where the panel's edge is [m] in the scene "carry": 2 cm in front of the fingers at their start."""
_CLEAR_OF_THE_ARM = (0.64, -0.27, 0.78)
"""In the scene "full": 4 cm in front of the fingers' ends at their start, so that they pass it on their way down; and
so far to the left that open fingers do not hide the marker from the head."""


class WorldParameters(Parameters):
    """Errors of the wrist's sensor, and what is around the robot: what every simulation of it may be told."""

    scene: SceneName = option(
        "full",
        "what is around it: load has bags on a rope; carry also a panel, a person and a camera, and the arm starts "
        "in front of the panel; full has all of it, and the arm starts as in load",
    )
    ft_noise: Vector6 = parameter(
        (0.1, 0.1, 0.1, 0.005, 0.005, 0.005),
        "N, Nm",
        0.0,
        50.0,
        "standard deviation of its noise, per axis; never below 1e-6, so that no axis looks stuck",
    )
    ft_bias: Vector6 = parameter((0.0,) * 6, "N, Nm", -100.0, 100.0, "its error at the start, per axis")
    ft_drift: Vector6 = parameter(
        (0.01, -0.01, 0.015, 0.0005, -0.0003, 0.0004),
        "N, Nm per minute",
        -100.0,
        100.0,
        "how that error drifts: within what wrench.zero_drift allows by default",
    )
    floor_slope: tuple[float, float] = parameter(
        (0.0, 0.0),
        "rad",
        -0.3,
        0.3,
        "rise of the floor along x and along y of base at the start; only in the scene load",
    )
    physics_rate: float = parameter(500.0, "Hz", 500.0, 4000.0, "of physics steps, at least")
    panel_size: Vector3 = parameter((1.2, 0.6, 0.05), "m", 0.02, 3.0, "length, width and thickness of the panel")
    panel_mass: float = parameter(1.5, "kg", 0.2, 10.0, "of the panel")
    panel_friction: float = parameter(0.6, "1", 0.0, 2.0, "of the panel on the ground and on its supports")
    panel_stiffness: float = parameter(
        12000.0,
        "N/m",
        500.0,
        20000.0,
        "of the panel's foam standing on an edge or lying on a face; it stands by itself on an edge of thickness t "
        "if this is above 4 m g h / t2, h the height of its centre: 7100 for the default panel",
    )
    panel_position: Vector3 = parameter(
        _CLEAR_OF_THE_ARM,
        "m",
        -5.0,
        5.0,
        "middle of the panel's edge towards the robot as it lies on its supports, in base at the start; "
        f"{list(_AHEAD_OF_THE_ARM)} by default in the scene carry",
    )
    panel_yaw: float = parameter(
        0.0, "rad", -1.5, 1.5, "of the panel on its supports, about the vertical through panel_position"
    )
    grip_friction: float = parameter(
        3.5,
        "1",
        0.0,
        10.0,
        "of the fingers' pads on the panel: about 0.9 for rubber, several for pads that bite into foam",
    )
    person_force: float = parameter(60.0, "N", 0.0, 200.0, "largest force of the person's hands")
    person_torque: float = parameter(20.0, "Nm", 0.0, 50.0, "largest torque of the person's hands")
    person_stiffness: float = parameter(
        STIFFNESS, "N/m", 50.0, 5000.0, "of the person's arms; about an axis 0.08 Nm/rad for each N/m"
    )
    marker_id: int = parameter(7, "", 0, 49, "of the ArUco marker (DICT_4X4_50)")
    marker_size: float = parameter(0.15, "m", 0.02, 0.5, "printed width of the marker's black square")
    marker_position: tuple[float, float] = parameter(
        (-0.35, 0.0),
        "m",
        -1.5,
        1.5,
        "of the marker's centre on the panel's upper face, from the panel's centre along its x and y",
    )
    light: float = parameter(1.0, "1", 0.0, 2.0, "brightness; 0 = dark")
    camera_noise: float = parameter(
        1.0,
        "of 255",
        0.5,
        50.0,
        "standard deviation of each pixel's red, green and blue; never none, so that no camera looks stuck",
    )
    seed: int = parameter(0, "", 0, 2**63 - 1, "of the noise of force-torque sensor and camera")

    @model_validator(mode="before")
    @classmethod
    def _placed(cls, given: Mapping[str, Any]) -> Mapping[str, Any]:
        return {"panel_position": _AHEAD_OF_THE_ARM, **given} if given.get("scene") == "carry" else given

    def panel_scene(self) -> PanelSceneSpec:
        """What the panel, the grip and the person are like."""
        panel = PanelSpec(
            self.panel_size,
            self.panel_mass,
            self.panel_friction,
            self.panel_stiffness,
            self.panel_position,
            self.panel_yaw,
        )
        return PanelSceneSpec(panel, self.grip_friction, self.person_force, self.person_torque, self.person_stiffness)

    def scenery(self) -> Scenery:
        """What the camera sees that does not change."""
        return Scenery(
            self.panel_size,
            self.marker_id,
            self.marker_size,
            self.marker_position,
            self.light,
            self.camera_noise,
            self.seed,
        )

    def check(self) -> None:
        """Whether there is no panel on a slope.

        Raises:
            Refused: if there is.
        """
        if any(self.floor_slope) and self.scene != "load":
            raise Refused(f'floor_slope is {list(self.floor_slope)} rad: only with scene="load", without a panel')


class SimParameters(WorldParameters):
    """Rates, sensor errors and speed limits of the simulated TIAGo, and what is around it."""

    ft_rate: float = parameter(100.0, "Hz", 30.0, 1000.0, "of the wrist's force-torque sensor")
    tells_gravity: bool = option(False, "sensor/ft says where down is, as a robot with a tilt sensor does")
    joint_rate: float = parameter(100.0, "Hz", 50.0, 1000.0, "of joint states and of the tool's pose")
    camera_rate: float = parameter(10.0, "Hz", 1.0, 30.0, "of the head camera")
    base_type: BaseType = option("differential", "kind of mobile base")
    real_time_factor: float = parameter(
        1.0,
        "1",
        0.03,
        10.0,
        "simulated seconds per second; rates are simulated, so ft_rate and joint_rate times this have to be 30 Hz "
        "or more; commands' ttl stays in real time",
    )
    require_enable: bool = option(False, "the gate moves nothing but while `operator/enable` is pressed")
    max_linear: float = parameter(0.3, "m/s", 0.01, 1.0, "largest speed of the tool's origin")
    max_angular: float = parameter(1.0, "rad/s", 0.01, 3.0, "largest turning rate of the tool")
    max_linear_acceleration: float = parameter(5.0, "m/s2", 0.1, 100.0, "of speeding up; slowing down is not limited")
    max_angular_acceleration: float = parameter(
        10.0, "rad/s2", 0.1, 100.0, "of speeding up; slowing down is not limited"
    )

    def check(self) -> None:
        """Whether what depends on the sensors hears from them often enough.

        Raises:
            Refused: if one of the rates is too slow in real time, or there is a panel on a slope.
        """
        super().check()
        for name in ("ft_rate", "joint_rate"):
            rate = getattr(self, name)
            if rate * self.real_time_factor < SLOWEST_RATE - 1e-9:
                raise Refused(
                    f"{name} is {rate:g} Hz at a real_time_factor of {self.real_time_factor:g}: "
                    f"{rate * self.real_time_factor:g} Hz of real time, allowed are {SLOWEST_RATE:g} Hz or more; "
                    f"raise {name} to {SLOWEST_RATE / self.real_time_factor:.4g} Hz"
                )
