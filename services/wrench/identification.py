"""Identification of the weight beyond the sensor and of the sensor's bias from several poses, by least squares.

With nothing touching the tool a reading in sensor axes is linear in ten unknowns (g_s is gravity in sensor axes):

    force  = m g_s + b_f                  4 unknowns: m, b_f
    torque = h x g_s + b_tau              6 unknowns: h = m c, b_tau

No unknown stands in both, so they are two problems, each solved on its own. The columns of m and h are divided by g:
unknowns are then forces and torques alone, and the condition numbers say how well the poses excite them. Only the
direction of gravity in the sensor's axes matters; it has to leave a straight line, or the part of h along that line
cannot be told from the bias. Standard deviations follow from the residuals, or from the noise of the averages where
that is larger: with few poses a small residual is luck.

A fit has to explain its data: its residuals are held against what white noise exceeds once in 30,000 fits (chi-square)
plus what attitudes that are wrong by their largest error make of the weight.

What the fit leaves of any effect that is linear in gravity's direction (gains, crosstalk, a soft cable) is E a, with a
that direction less its mean over the poses, since each axis has its own bias. Of that the poses have seen E S E^T,
S = mean of a a^T, so in any attitude axis i of it is at most rms_i sqrt(a^T S^-1 a): small among the poses, large
outside.
"""

from __future__ import annotations

import math

import numpy as np

from services.wrench.averaging import SIGMAS, Average
from services.wrench.compensation import Compensation, gravity_in_sensor
from shared.schema.fields import Integer, Number, Vector
from shared.schema.records import Record, of
from shared.spatial import GRAVITY, Array, skew

LARGEST_CONDITION = 30.0  # [1] above it the readings' errors come out thirty times as large in the unknowns
_SHARPEST = 1e-4  # [1] added to S: what directions that no pose has shown are taken to be known to, squared
_QUANTILE = 4.0  # standard deviations of normal noise that are exceeded, upwards, once in 30,000 times
FEWEST_POSES = 3  # three directions of gravity that do not lie on one line determine the ten unknowns


class NotExciting(ValueError):
    """The poses do not determine the unknowns; the text says which motion is missing."""


class NoWeight(NotExciting):
    """The poses give no weight that hangs from the sensor."""


class IdentifiedPayload(Record):
    """The result in sensor axes; ``sigma_*`` are standard deviations. A payload file holds these fields."""

    mass: float = of(Number("kg", above=0.0))
    com: Array = of(Vector("m", "centre of mass from the sensor's origin"))
    force_bias: Array = of(Vector("N"))
    torque_bias: Array = of(Vector("Nm"))
    sigma_mass: float = of(Number("kg", minimum=0.0))
    sigma_com: Array = of(Vector("m", minimum=0.0))
    sigma_force_bias: Array = of(Vector("N", minimum=0.0))
    sigma_torque_bias: Array = of(Vector("Nm", minimum=0.0))
    residual_rms: Array = of(Vector("N, Nm", "over the poses", size=6, minimum=0.0))
    residual_peak: Array = of(Vector("N, Nm", "over the poses", size=6, minimum=0.0))
    noise: Array = of(Vector("N, Nm", "bound on the noise of one reading", size=6, minimum=0.0))
    condition: float = of(Number(doc="the larger condition number of the two scaled problems"))
    poses: int = of(Integer(doc="how many were used"))
    down: Array = of(Vector("", "mean direction of gravity over the poses, sensor axes"), default=(0.0,) * 3)
    spread: Array = of(
        Vector("", "inverse of the directions' covariance, row by row; zeros if it is not known", size=9),
        default=(0.0,) * 9,
    )

    def compensation(self) -> Compensation:
        """What to subtract from readings, with bounds on its error."""
        bias_sigma = np.concatenate((self.sigma_force_bias, self.sigma_torque_bias))
        com_length = float(np.linalg.norm(self.com))
        moment_sigma = self.mass * float(np.linalg.norm(self.sigma_com)) + com_length * self.sigma_mass
        return Compensation(
            "payload",
            bias=np.concatenate((self.force_bias, self.torque_bias)),
            # What the model does not explain (a bent cable, a sensor off its calibration) shows in the residuals.
            bias_error=SIGMAS * bias_sigma,
            misfit_rms=self.residual_rms,
            misfit_peak=self.residual_peak,
            down=self.down,
            # Of a file that does not tell, the poses' condition has to tell how far they reach.
            spread=self.spread if self.spread.any() else (4.0 * self.condition) ** 2 * np.eye(3).ravel(),
            mass=self.mass,
            moment=self.mass * self.com,
            mass_error=SIGMAS * self.sigma_mass,
            moment_error=SIGMAS * moment_sigma,
            noise=self.noise,
        )


def identify(poses: list[Average]) -> IdentifiedPayload:
    """Weight and bias from averages at several poses with nothing touching the tool.

    Raises:
        NotExciting: if the poses do not determine the unknowns.
        NoWeight: if there is no weight to be found, or one that pulls upwards.
    """
    if len(poses) < FEWEST_POSES:
        raise NotExciting(
            f"{len(poses)} poses were added, wanted at least {FEWEST_POSES}, "
            "with gravity in clearly different directions of the sensor"
        )
    down = np.array([gravity_in_sensor(pose.rotation) / GRAVITY for pose in poses])
    force_rows, torque_rows = _design(down)
    condition = max(_condition(force_rows), _condition(torque_rows))
    if condition > LARGEST_CONDITION:
        raise NotExciting(_missing(down, condition))
    means = np.array([pose.mean for pose in poses])
    mean_sigma = np.sqrt(np.mean([pose.variance for pose in poses], axis=0))
    force, force_covariance, force_residuals = _least_squares(force_rows, means[:, :3], mean_sigma[:3])
    torque, torque_covariance, torque_residuals = _least_squares(torque_rows, means[:, 3:], mean_sigma[3:])
    mass, sigma_mass = force[0] / GRAVITY, np.sqrt(force_covariance[0, 0]) / GRAVITY
    if mass < -SIGMAS * sigma_mass:
        raise NoWeight(f"the weight found, {mass:.4f} kg, pulls upwards: no payload does")
    if mass <= SIGMAS * sigma_mass:
        raise NoWeight(
            f"the weight found, {mass:.4f} kg with a standard deviation of {sigma_mass:.4f} kg, does not stand out: "
            "is anything mounted beyond the sensor, does nothing touch it? Or do the readings not turn with it, being "
            "given in base axes, or compensated already?"
        )
    com = torque[:3] / force[0]
    com_variance = (np.diag(torque_covariance)[:3] + com**2 * force_covariance[0, 0]) / force[0] ** 2
    residuals = np.hstack((force_residuals, torque_residuals))
    away = down - down.mean(axis=0)
    return IdentifiedPayload(
        mass=float(mass),
        com=com,
        force_bias=force[1:],
        torque_bias=torque[3:],
        sigma_mass=float(sigma_mass),
        sigma_com=np.sqrt(com_variance),
        sigma_force_bias=np.sqrt(np.diag(force_covariance)[1:]),
        sigma_torque_bias=np.sqrt(np.diag(torque_covariance)[3:]),
        residual_rms=np.maximum(np.sqrt((residuals**2).mean(axis=0)), mean_sigma),
        residual_peak=np.abs(residuals).max(axis=0),
        noise=np.max([pose.noise for pose in poses], axis=0),
        condition=condition,
        poses=len(poses),
        down=down.mean(axis=0),
        spread=np.linalg.inv(away.T @ away / len(poses) + _SHARPEST * np.eye(3)).ravel(),
    )


def misfit(result: IdentifiedPayload, poses: list[Average], tilt: float) -> Array:
    """Mean squares of the residuals (2,) of forces and torques, as shares of what noise and attitude explain at most.

    Args:
        result: of these poses.
        poses: that were identified.
        tilt: largest error of the attitude [rad].
    """
    weight = result.mass * GRAVITY * tilt
    arm = float(np.linalg.norm(result.com))
    variance = np.mean([pose.variance + pose.rounding**2 / 3.0 for pose in poses], axis=0)
    count = 3 * len(poses)
    noise = np.sqrt(variance * np.repeat([_chi_square(count - k) / count for k in (4, 6)], 3))
    # No attitude is wrong by more than the tilt: as a bound it adds to the noise, and is no standard deviation itself.
    wrong = weight / math.sqrt(3.0) * np.repeat((1.0, arm), 3)
    return np.asarray((result.residual_rms / np.maximum(noise + wrong, 1e-9)) ** 2).reshape(2, 3).mean(axis=1)


def _chi_square(freedom: int) -> float:
    """Quantile of the chi-square distribution beyond which `_QUANTILE` lies (Wilson and Hilferty's approximation)."""
    part = 2.0 / (9.0 * freedom)
    return freedom * (1.0 - part + _QUANTILE * math.sqrt(part)) ** 3


def _design(down: Array) -> tuple[Array, Array]:
    """Rows (3 n, 4) of the forces in [m g, b_f] and (3 n, 6) of the torques in [h g, b_tau]."""
    identity = np.eye(3)
    force_rows = np.vstack([np.column_stack((direction, identity)) for direction in down])
    torque_rows = np.vstack([np.column_stack((-skew(direction), identity)) for direction in down])
    return force_rows, torque_rows


def _condition(rows: Array) -> float:
    singular = np.linalg.svd(rows, compute_uv=False)
    return float(singular[0] / singular[-1]) if singular[-1] > 1e-9 * singular[0] else math.inf


def _least_squares(rows: Array, means: Array, sigma: Array) -> tuple[Array, Array, Array]:
    """Solution (k,), its covariance (k, k) and the residuals (n, 3) of readings ``means`` (n, 3).

    The covariance takes the worst axis for all three, with the larger of the two estimates of its variance.
    """
    solution = np.asarray(np.linalg.lstsq(rows, means.ravel(), rcond=None)[0], dtype=np.float64)
    residuals: Array = (means.ravel() - rows @ solution).reshape(means.shape)
    freedom = means.size - rows.shape[1]
    inverse = np.asarray(np.linalg.inv(rows.T @ rows), dtype=np.float64)
    variance = max(float((residuals**2).sum()) / freedom, float((sigma**2).max()))
    return solution, variance * inverse, residuals


def _missing(down: Array, condition: float) -> str:
    """Which motion would make the poses determine the unknowns: one line."""
    centred = down - down.mean(axis=0)
    _, spreads, directions = np.linalg.svd(centred)
    spread = abs(float(spreads[0])) / math.sqrt(len(down))
    start = f"the poses do not determine the payload (condition {condition:.3g}, allowed is {LARGEST_CONDITION:g}): "
    if spread < 0.1:
        return start + (
            f"the sensor's tilt varies by only {math.degrees(spread):.1f} degrees (turning about the vertical does "
            "not count). Add poses tilted by 30 degrees or more, about two different axes"
        )
    # Turning about the axis a moves gravity along a x down: perpendicular to the line seen so far if a is that line.
    axis = "xyz"[int(np.argmax(np.abs(directions[0])))]
    return start + (
        f"the sensor was tilted about one axis only. Add poses tilted by 30 degrees or more about its {axis} axis too"
    )
