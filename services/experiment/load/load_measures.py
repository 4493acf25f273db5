"""Figures taken from one run's recording: what the tool and the load did in each part of the load experiment.

All of them come from published topics alone: `state/ee` (tool), `wrench/external` (load), `sim/world` (bag) and the
events of the protocol, so the same figures can be taken on a real robot as far as its bag's height is known.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from services.experiment.measure.brakes import Brake, brakes, undisturbed
from services.experiment.measure.disturbance import longest_gap, unhealthy
from services.experiment.measure.series import rate
from services.experiment.play.recording import Recording
from shared import topics

GROUND = 0.005  # [m]: a bag lower than this touches the ground
REVERSAL = 0.003  # [m]: a smaller turn-round of the tool is noise, not oscillation
HANDED_OVER = 1.0  # [s] for the person who hangs the bag to let go of it, and for the rope to come to rest
SETTLED = 2.0  # [s] averaged for a resting value
AFTER_LANDING = 1.0  # [s] for the tool to stop once the bag has touched the ground


@dataclass(frozen=True)
class Measures:
    """One run in figures. Times [s] on the experiment's clock, lengths [m], forces [N]; NaN where it did not happen."""

    hold_height: float  # tool z before the first bag
    hold_error: float  # largest departure from it while the light bag hangs
    sag: float  # how far below it the tool rests under the light bag
    excess_before: float  # largest |w_i| / limit_i over the six axes until the heavier bag
    landing: float  # when the heavier bag first touches the ground
    lowering_time: float  # from the heavier bag to the ground
    drop: float  # how far the tool went down for it
    peak_speed: float  # largest downward speed on the way [m/s]
    load_swing: float  # half the range that holds the load on the way down, but for 20 % of it and what brakes upset
    judged_way: float  # share of the way that no brake upset
    brakes: tuple[Brake, ...]  # on the way down
    reversals: int  # turn-rounds on the way that are larger than REVERSAL
    bag_height: float  # mean height of the bag over the last seconds before it is taken off
    lift: float  # how far the bag was lifted off the ground again, at most
    ground_peak: float  # largest -force z there
    ground_ripple: float  # standard deviation of tool z there
    return_error: float  # distance from the hold pose at the end
    return_time: float  # from taking the bag off to staying within 1 cm
    error_bound: float  # published bound on force z
    max_linear: float  # the tool's speed limit that the robot publishes [m/s]
    longest_gap: float  # between two samples of the force sensor: how well the machine kept time
    unhealthy: float  # share of the time during which the controller braked or waited


def measure(recording: Recording) -> Measures:
    """Takes the figures of one run; KeyError or ValueError says what the recording lacks."""
    light, heavy, unload = (_when(recording, name) for name in ("light", "heavy", "unload"))
    ee = topics.STATE_EE.key
    time, position = recording.time(ee), recording.series(ee, "position")
    height = position[:, 2]
    settled = _within(time, light - SETTLED, light)
    rest = np.median(position[settled], axis=0)
    held = _within(time, light, heavy)

    world = topics.SIM_WORLD.key
    bag_time, bag_height = recording.time(world), recording.series(world, "bag.height")
    grounded = (bag_time > heavy) & (bag_time < unload) & (bag_height <= GROUND)
    landing = float(bag_time[grounded][0]) if grounded.any() else float("nan")
    lowered = landing if grounded.any() else unload
    way = _within(time, heavy, lowered)
    landed = _within(bag_time, landing + AFTER_LANDING, unload) if grounded.any() else np.zeros(len(bag_time), bool)

    wrench = topics.WRENCH_EXTERNAL.key
    force_time, load = recording.time(wrench), -recording.series(wrench, "force")[:, 2]
    braked = tuple(brake for brake in brakes(recording) if brake.end >= heavy and brake.start < lowered)
    hanging = _within(force_time, heavy + HANDED_OVER, lowered)
    judged = hanging & undisturbed(force_time, braked)
    ground = _within(force_time, landing + AFTER_LANDING, unload)
    ground_way = _within(time, landing + AFTER_LANDING, unload)
    back = np.linalg.norm(position - rest, axis=1)
    after = time >= unload
    away = time[after & (back > 0.01)]

    return Measures(
        hold_height=float(rest[2]),
        hold_error=float(np.max(np.abs(height[held] - rest[2]))),
        sag=float(rest[2] - np.median(height[_within(time, heavy - SETTLED, heavy)])),
        excess_before=_excess(recording, heavy),
        landing=landing,
        lowering_time=landing - heavy,
        drop=float(rest[2] - np.min(height[way], initial=rest[2])),
        peak_speed=float(-np.min(rate(time, height[:, None])[way], initial=0.0)),
        load_swing=_swing(load[judged], 0.1 * np.sum(hanging)),
        judged_way=float(np.sum(judged) / max(1, np.sum(hanging))),
        brakes=braked,
        reversals=reversals(height[way], REVERSAL),
        bag_height=float(np.mean(bag_height[_within(bag_time, unload - SETTLED, unload)])),
        lift=float(np.max(bag_height[landed])) if landed.any() else float("nan"),
        ground_peak=float(np.max(load[ground])) if ground.any() else float("nan"),
        ground_ripple=float(np.std(height[ground_way])) if ground_way.any() else float("nan"),
        return_error=float(np.max(back[time >= time[-1] - 0.5])),
        return_time=float((away[-1] if away.size else unload) - unload),
        error_bound=float(np.max(recording.series(wrench, "error_bound")[force_time >= 0.0, 2])),
        longest_gap=longest_gap(recording),
        unhealthy=unhealthy(recording),
        max_linear=float(recording.series(topics.STATE_ROBOT.key, "max_linear")[-1]),
    )


def _swing(load: np.ndarray, outliers: float) -> float:
    """Half the range [N] of the load (n,) without so many of its largest and as many of its smallest values."""
    if len(load) <= 2 * outliers:
        return float("nan")
    return float(np.ptp(np.quantile(load, (outliers / len(load), 1.0 - outliers / len(load))))) / 2


def reversals(values: np.ndarray, threshold: float) -> int:
    """How often a series turns round by more than `threshold`: 0 for a monotone one, whatever its noise below that."""
    count, direction = 0, 0
    low = high = values[0] if len(values) else 0.0
    for value in values:
        low, high = min(low, value), max(high, value)
        if direction >= 0 and value < high - threshold:
            count, direction, low = count + (direction > 0), -1, value
        elif direction <= 0 and value > low + threshold:
            count, direction, high = count + (direction < 0), 1, value
    return count


def _excess(recording: Recording, until: float) -> float:
    wrench = topics.WRENCH_EXTERNAL.key
    time = recording.time(wrench)
    values = np.hstack([recording.series(wrench, "force"), recording.series(wrench, "torque")])
    limits = np.array([*recording.meta["force_limit"], *recording.meta["torque_limit"]])
    return float(np.max(np.abs(values[_within(time, 0.0, until)]) / limits))


def _within(time: np.ndarray, start: float, end: float) -> np.ndarray:
    return (time >= start) & (time < end)


def _when(recording: Recording, name: str) -> float:
    event = recording.event(name)
    if event is None:
        raise ValueError(
            f"run {recording.meta.get('name')}: the recording has no event {name!r}: the run did not finish"
        )
    return event.time
