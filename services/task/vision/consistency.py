"""Whether views of a marker at rest agree on where it is, and which single error in what is told would explain it.

Four corners give eight numbers, a pose takes six: one view fits almost any calibration. Seen from a head that has
turned, the same error moves the marker in base another way; so several views together fit one calibration only.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from services.task.geometry import Pose
from services.task.vision.projection import Calibration, corners_seen
from shared.spatial import Array, rotation_from_vector

AGREE, AGREE_ANGLE = 0.01, math.radians(2.0)  # [m], [rad] by which the views of a marker at rest may differ in base
_STEPS = 30  # of a fit at most; five are usual
_ENOUGH = 1e-5  # [1] by which a step has to lower the sum of squares for another one to be taken
_CLEARLY = 7.0
"""Difference in log likelihood, with the Bayesian information criterion's price for each value that is fitted, from
which one cause explains the views clearly better than another: odds of 1000 to 1."""
_FARTHEST, _FARTHEST_OFF = 20.0, 5.0  # [m], [1] of the marker and of a cause's values: a fit goes no farther
_TOLD_CAUSES = 3  # named in a sentence at most


@dataclass(frozen=True, eq=False)
class View:
    """A marker at rest, seen by a camera at rest.

    Attributes:
        corners: (4, 2) [px], in order.
        camera: its optical frame in base, as told.
    """

    corners: Array
    camera: Pose


@dataclass(frozen=True, eq=False)
class Cause:
    """One way in which what is told may be wrong.

    Attributes:
        changed: what is told, corrected by values (k,) that are 0 for "as told" and about 1 for "far off".
        starts: values (k,) from which to look.
        words: says the values to a person.
    """

    changed: Callable[[Calibration, Array], Calibration]
    starts: tuple[tuple[float, ...], ...]
    words: Callable[[Calibration, Calibration], str]


@dataclass(frozen=True, eq=False)
class Fit:
    """The marker and the values of a cause that explain views best.

    Attributes:
        marker: in base.
        told: the calibration as it would have to be.
        rms: what remains at each corner's coordinate [px].
        values: number of values that were fitted besides the pose.
        spread: of the marker's position [m per px] and attitude [rad per px], for an error of the corners' coordinates.
    """

    marker: Pose
    told: Calibration
    rms: float
    values: int
    spread: Array


@dataclass(frozen=True, eq=False)
class Verdict:
    """What views of a marker at rest say.

    Attributes:
        marker: in base, as all views together have it.
        apart: largest distance [m] between two views' markers, beyond what corners can be measured to.
        turned: largest angle [rad] between them, likewise.
        shift: how far [m] the marker is elsewhere if the likeliest single cause is the case; 0 without a clear one.
        causes: what explains the differences, the best first, in words; empty if nothing does.
    """

    marker: Pose
    apart: float
    turned: float
    shift: float
    causes: tuple[str, ...]

    @property
    def consistent(self) -> bool:
        """Whether the marker is to be believed."""
        return self.apart <= AGREE and self.turned <= AGREE_ANGLE and self.shift <= AGREE


def _scaled(told: Calibration, x: float, y: float, centre: float = 0.0) -> Calibration:
    scale = np.exp((x, y, centre, centre))
    return replace(told, intrinsics=told.intrinsics * scale)


def _distorted(told: Calibration, values: Array) -> Calibration:
    lens = np.pad(told.distortion, (0, 8 - len(told.distortion)))
    return replace(told, distortion=lens + np.concatenate((values, np.zeros(6))))


def _ratio(told: Calibration, fit: Calibration) -> str:
    fx, fy = fit.intrinsics[:2] / told.intrinsics[:2]
    return f"{fx:.3f} and {fy:.3f} times as told"


CAUSES = {
    "centre (cx, cy)": Cause(
        lambda told, v: replace(told, intrinsics=told.intrinsics + 100.0 * np.array((0.0, 0.0, *v))),
        ((0.0, 0.0),),
        lambda told, fit: "{:+.0f} and {:+.0f} px from what is told".format(*(fit.intrinsics - told.intrinsics)[2:]),
    ),
    "focal length (fx, fy)": Cause(lambda told, v: _scaled(told, v[0], v[1]), ((0.0, 0.0),), _ratio),
    "calibration of another resolution": Cause(
        lambda told, v: _scaled(told, v[0], v[0], v[0]), ((0.0,), (0.7,), (-0.7,)), _ratio
    ),
    "distortion": Cause(
        _distorted,
        ((0.0, 0.0),),
        lambda told, fit: "k1 and k2 {:+.2f} and {:+.2f} from what is told, as of a raw picture or another lens".format(
            *(fit.distortion[:2] - np.pad(told.distortion, (0, 2))[:2])
        ),
    ),
    "rectified picture with the distortion of the raw one": Cause(
        lambda told, v: replace(told, distortion=np.zeros(0)), ((),), lambda told, fit: "send zeros with it"
    ),
    "camera's orientation in base (its mounting)": Cause(
        lambda told, v: replace(told, turn=v),
        ((0.0, 0.0, 0.0),),
        lambda told, fit: f"turned by {math.degrees(float(np.linalg.norm(fit.turn))):.1f} degrees",
    ),
    "marker_size": Cause(
        lambda told, v: replace(told, size=told.size * math.exp(v[0])),
        ((0.0,),),
        lambda told, fit: f"{fit.size:.3f} m instead of {told.size:g} m",
    ),
}
_NOTHING = Cause(lambda told, v: told, ((),), lambda told, fit: "")


def differences(views: Sequence[View], start: Pose, told: Calibration, accuracy: float) -> tuple[float, float]:
    """Largest distance [m] and angle [rad] in base between the markers that two or more views show, each by itself.

    Without three standard deviations of what corners measured to ``accuracy`` [px] make of it.
    """
    pairs = list(combinations([fitted([view], start, told, _NOTHING, 1.0) for view in views], 2))
    found = [
        (one.marker.distance(other.marker), one.marker.angle(other.marker))
        - 3.0 * accuracy * np.hypot(one.spread, other.spread)
        for one, other in pairs
    ]
    apart, turned = np.maximum(0.0, np.max(found, axis=0))
    return float(apart), float(turned)


def judged(views: Sequence[View], start: Pose, told: Calibration, accuracy: float, head: float) -> Verdict:
    """What views say together.

    Args:
        views: of a marker that rests, two or more.
        start: about where it is in base.
        told: what is told about camera and marker.
        accuracy: standard deviation [px] to which a corner's coordinate is measured.
        head: that [rad] to which each pose of the camera is known.
    """
    common = accuracy / math.hypot(accuracy, 2.0 * head * float(told.intrinsics[:2].mean()))
    apart, turned = differences(views, start, told, accuracy)
    as_told = fitted(views, start, told, _NOTHING, common)
    fits = {name: fitted(views, as_told.marker, told, cause, common) for name, cause in CAUSES.items()}
    count = 8 * len(views)

    def cost(fit: Fit) -> float:
        return 0.5 * (count * math.log(fit.rms**2 + accuracy**2) + fit.values * math.log(count))

    order = sorted(fits, key=lambda name: cost(fits[name]))
    best = fits[order[0]]
    clear = [name for name in order if cost(fits[name]) < cost(as_told) - _CLEARLY]
    likely = [name for name in clear if cost(fits[name]) < cost(best) + _CLEARLY][:_TOLD_CAUSES]
    words = tuple(f"{name}: {CAUSES[name].words(told, fits[name].told)}" for name in likely)
    shift = max((fits[name].marker.distance(as_told.marker) for name in likely), default=0.0)
    return Verdict(as_told.marker, apart, turned, shift, words)


def fitted(views: Sequence[View], start: Pose, told: Calibration, cause: Cause, common: float) -> Fit:
    """The marker in base and a cause's values with the least reprojection error, by Levenberg and Marquardt.

    Args:
        views: of the marker.
        start: about where it is.
        told: what is told.
        cause: whose values are fitted too.
        common: weight [1] of what all corners of a view are off alike.
    """
    fits = [_fitted(views, start, told, cause, common, np.array(values)) for values in cause.starts]
    return min(fits, key=lambda fit: fit.rms)


@np.errstate(all="ignore")
def _fitted(views: Sequence[View], start: Pose, told: Calibration, cause: Cause, common: float, values: Array) -> Fit:
    seen = np.array([view.corners for view in views])
    cameras = [view.camera for view in views]
    beyond = np.full(seen.size, 1e6)

    def moved(step: Array) -> tuple[Pose, Array]:
        return Pose(marker.position + step[:3], rotation_from_vector(step[3:6]) @ marker.rotation), values + step[6:]

    def error(marker: Pose, values: Array) -> Array:
        if max(np.abs(values), default=0.0) > _FARTHEST_OFF or np.abs(marker.position).max() > _FARTHEST:
            return beyond
        there = corners_seen(marker, cameras, cause.changed(told, values))
        if there is None:
            return beyond
        off = there - seen
        # What a head's own inaccuracy does to all corners of a view alike counts as little as it says.
        return (off - (1.0 - common) * off.mean(axis=1, keepdims=True)).ravel()

    marker = start
    unit: Array = 1e-6 * np.eye(6 + len(values))
    residual, damping = error(marker, values), 1e-3
    normal: Array = np.eye(len(unit))
    for _ in range(_STEPS):
        slope = np.stack([(error(*moved(step)) - residual) / 1e-6 for step in unit], axis=1)
        if not np.isfinite(slope).all():
            break
        normal, before = slope.T @ slope, float(residual @ residual)
        while damping < 1e8:
            stiff = normal + damping * np.diag(np.diag(normal) + 1e-9)
            step = np.asarray(np.linalg.solve(stiff, -slope.T @ residual), dtype=np.float64)
            trial = moved(step)
            after = error(*trial)
            if after @ after < before:
                break
            damping *= 10.0
        else:
            break
        (marker, values), residual, damping = trial, after, damping / 10.0
        if before - after @ after < _ENOUGH * before:
            break
    variances = np.diag(np.linalg.pinv(normal))
    spread = np.sqrt((variances[:3].sum(), variances[3:6].sum()))
    return Fit(marker, cause.changed(told, values), float(np.sqrt(np.mean(residual**2))), len(values), spread)
