"""What can go wrong in a carry: each takes a copy of a good recording, and spoils it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

from services.experiment.carry.carry_protocol import PANEL_SIZE
from services.experiment.measure.series import at
from services.experiment.play.recording import Recording
from services.sim.scene.hands import STIFFNESS

Defect = Callable[[Recording], None]
ARM = 0.15  # [m] that the arm reaches to and fro
RESISTS = 0.06  # [m] that the hands want to be ahead when the person stops, at 30 N


def when(recording: Recording, state: str) -> float:
    """Time [s] at which the task came to a state."""
    event = recording.event(state)
    assert event is not None
    return event.time


def during(recording: Recording, topic: str, start: float, end: float) -> np.ndarray:
    time = recording.time(topic)
    return (time >= start) & (time < end)


def add(topic: str, name: str, value: tuple[float, ...], start: float, end: float) -> Defect:
    """Something is added to a series for a time [s]."""

    def spoil(recording: Recording) -> None:
        recording.topics[topic][name][during(recording, topic, start, end)] += value

    return spoil


def asks_for_more(recording: Recording) -> None:
    """The task widens the limit that the panel's yaw breaks, for a second."""
    add("control/target", "torque_limit", (0.5, 0.0, 0.0), 30.0, 31.0)(recording)


def centred_too_low(recording: Recording) -> None:
    """The task takes all of the panel's weight for agreed, so that its limits leave more room."""
    add("control/target", "nominal_force", (0.0, 0.0, -7.4), 30.0, 31.0)(recording)


def centred_aside(recording: Recording) -> None:
    """The task takes a torque for agreed."""
    add("control/target", "nominal_torque", (0.1, 0.0, 0.0), 30.0, 31.0)(recording)


def lost(recording: Recording) -> None:
    """The fingers slip in the middle of the carry, and the robot's end of the panel falls."""
    at = 30.0
    gripper, world = recording.topics["state/gripper"], recording.topics["sim/world"]
    gripper["holding"][gripper["time"] > at] = False
    after = world["time"] > at
    fallen = np.minimum(0.5 * 9.81 * (world["time"][after] - at) ** 2, 0.8)
    world["panel.position"][after, 2] -= fallen / 2
    tilted(recording, 30.0, at, np.inf)


def slipped_unseen(recording: Recording) -> None:
    """The robot's end falls by a decimetre, and the gripper says that it holds."""
    world = recording.topics["sim/world"]
    fall = np.clip(world["time"] - 30.0, 0.0, 0.1)[:, None]
    world["panel.position"] -= fall * (0.0, 0.0, 1.0)


def let_go_early(recording: Recording) -> None:
    """The gripper opens while the panel is still on its way down."""
    gripper = recording.topics["state/gripper"]
    gripper["holding"][gripper["time"] > when(recording, "releasing") - 3.0] = False


def let_go_above(recording: Recording) -> None:
    """The task takes the panel to be on the ground when it is 2 cm above it."""
    add("sim/world", "panel.position", (0.0, 0.0, 0.02), when(recording, "releasing"), np.inf)(recording)


def let_go_loaded(recording: Recording) -> None:
    """The gripper opens while it still carries most of the weight."""
    add("wrench/external", "force", (0.0, 0.0, -13.0), when(recording, "releasing"), np.inf)(recording)


def touched_before(recording: Recording) -> None:
    """No defect: closing, the fingers touch the panel and lose it again before they hold it."""
    gripper = recording.topics["state/gripper"]
    grasped = int(np.argmax(gripper["holding"]))
    gripper["holding"][grasped - 4 : grasped - 2] = True


def never_let_go(recording: Recording) -> None:
    """The gripper goes on holding the panel."""
    gripper = recording.topics["state/gripper"]
    gripper["holding"][gripper["time"] > 20.0] = True


def stuck(recording: Recording) -> None:
    """The task goes on carrying for ever."""
    status = recording.topics["task/status"]
    status["state"][status["time"] > 20.0] = "carrying"


def tilted(recording: Recording, degrees: float = 20.0, start: float = 30.0, end: float = 31.0) -> None:
    """The panel's long axis is far off the horizontal."""
    world = recording.topics["sim/world"]
    then = during(recording, "sim/world", start, end)
    turned = Rotation.from_euler("y", -degrees, degrees=True) * Rotation.from_quat(world["panel.orientation"][then])
    world["panel.orientation"][then] = turned.as_quat()


def not_turned(recording: Recording) -> None:
    """The panel is turned by three quarters of what the person wants."""
    world = recording.topics["sim/world"]
    axes = Rotation.from_quat(world["panel.orientation"])
    roll = np.arctan2(axes.as_matrix()[:, 2, 1], axes.as_matrix()[:, 2, 2])
    back = Rotation.from_rotvec(np.outer(-0.25 * roll, (1.0, 0.0, 0.0)))
    world["panel.orientation"] = (axes * back).as_quat()


def slips_round(recording: Recording) -> None:
    """The panel turns in the fingers: the tool gets three quarters of the turn."""
    arm = recording.topics["state/ee"]
    axes = Rotation.from_quat(arm["orientation"])
    start = axes[int(np.searchsorted(arm["time"], when(recording, "carrying")))]
    turned = (axes * start.inv()).as_rotvec()
    turned[:, 0] *= np.where(arm["time"] > when(recording, "carrying"), 0.75, 1.0)
    arm["orientation"] = (Rotation.from_rotvec(turned) * start).as_quat()


def held_back(recording: Recording) -> None:
    """The base goes four fifths of the way only, and everything with it; the hands pull the harder."""
    base = recording.topics["state/base"]
    missing = -0.2 * (base["position"] - base["position"][0])
    _shift(recording, missing)
    base["position"] += missing


def base_stands(recording: Recording) -> None:
    """The base stands: the panel gets as far as the arm reaches, and the person stops when it resists."""
    base, arm = recording.topics["state/base"], recording.topics["state/ee"]
    gone = base["position"] - base["position"][0]
    reached = np.clip(gone, -ARM, ARM)
    heading = Rotation.from_rotvec(np.outer(np.interp(arm["time"], base["time"], base["yaw"]), (0.0, 0.0, 1.0)))
    arm["position"] += heading.inv().apply(at(arm["time"], base["time"], reached) @ np.eye(2, 3))
    base["position"] -= gone
    _shift(recording, reached - gone)
    world = recording.topics["sim/world"]
    ahead = world["hand.wanted"] - world["hand.position"]
    world["hand.wanted"] = world["hand.position"] + np.clip(ahead, -RESISTS, RESISTS)


def swings(recording: Recording) -> None:
    """The base does not go sideways: the panel swings about the robot's end, and the far end gets where it should."""
    base, world = recording.topics["state/base"], recording.topics["sim/world"]
    aside = base["position"][:, 1] - base["position"][0, 1]
    base["position"][:, 1] -= aside
    left = np.interp(world["time"], base["time"], aside)
    world["panel.position"][:, 1] -= left / 2.0
    yawed = Rotation.from_rotvec(np.outer(left / PANEL_SIZE[0], (0.0, 0.0, 1.0)))
    world["panel.orientation"] = (yawed * Rotation.from_quat(world["panel.orientation"])).as_quat()


def answers_late(recording: Recording) -> None:
    """Base and arm answer a second late: the panel rests so long, and the hands pull at it."""
    world = recording.topics["sim/world"]
    before = np.maximum(np.searchsorted(world["time"], world["time"] - 1.0), 0)
    behind = world["hand.position"] - world["hand.position"][before]
    for name in ("panel.position", "panel.orientation", "hand.position", "hand.force", "hand.torque"):
        world[name] = world[name][before]
    world["hand.force"] += STIFFNESS * behind
    for topic in ("state/base", "state/ee"):
        recording.topics[topic]["time"] = recording.topics[topic]["time"] + 1.0


def _shift(recording: Recording, missing: np.ndarray) -> None:
    """Panel and hands are elsewhere by (n, 2) [m] on the times of `state/base`; the hands pull with their stiffness."""
    world = recording.topics["sim/world"]
    shift = at(world["time"], recording.time("state/base"), missing) @ np.eye(2, 3)
    world["panel.position"] += shift
    world["hand.position"] += shift
    world["hand.force"] -= STIFFNESS * shift


def topples(recording: Recording) -> None:
    """The panel falls over after everybody has let go."""
    world = recording.topics["sim/world"]
    then = world["time"] > world["time"][-1] - 2.0
    lying = Rotation.from_quat(world["panel.orientation"][then]) * Rotation.from_euler("x", -80.0, degrees=True)
    world["panel.orientation"][then] = lying.as_quat()


def pushed_away(recording: Recording) -> None:
    """The panel slides when the person lets go."""
    add("sim/world", "panel.position", (0.0, 0.05, 0.0), when(recording, "done"), np.inf)(recording)


def brakes(share: float) -> Defect:
    """The controller brakes for a share of each second, and forces rise meanwhile and a moment longer."""

    def spoil(recording: Recording) -> None:
        status, wrench = recording.topics["control/status"], recording.topics["wrench/external"]
        carrying = (status["time"] > 20.0) & (status["time"] < 60.0)
        braked = carrying & (status["time"] % 5.0 < 5.0 * share)
        status["state"] = np.where(braked, "braking", status["state"])
        status["reason"] = np.where(braked, "wrench/external is late", status["reason"])
        late = wrench["time"] - 0.02
        risen = (late > 20.0) & (late < 60.0) & (late % 5.0 < 5.0 * share + 0.3)
        wrench["force"][risen, 1] += 20.0

    return spoil
