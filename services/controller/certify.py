"""``python -m services.controller.certify``: what the certified law guarantees with a configuration."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence

import numpy as np

from services.controller.guarantee import MOVING_FACTOR, Certificate, certificates, response, stiffness
from services.controller.parameters import ControllerParameters
from shared.loop.config import Misconfigured, OneLineParser, complain, service_parameters, service_parser
from shared.spatial import Array, rotation_matrix

_UNITS = (("mm/s", "N"), ("mrad/s", "Nm"))
_PARALLEL = "0,0,0,1"


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the certificate; returns the exit status, 2 after a bad option or configuration."""
    try:
        options = _parser().parse_args(arguments)
        parameters = service_parameters("controller", ControllerParameters, options.config, options.set)
        limit = np.concatenate(
            (_three("--force-limit", options.force_limit), _three("--torque-limit", options.torque_limit))
        )
        error_bound = np.concatenate(
            (_three("--force-error", options.force_error), _three("--torque-error", options.torque_error))
        )
        rotations = [_rotation(text) for text in options.orientation or [_PARALLEL]]
        found = certificates(parameters, limit, error_bound, options.environment_speed)
    except (Misconfigured, ValueError) as problem:
        return complain("certify", problem)
    if options.json:
        answer = _as_map(parameters, limit, error_bound, found, options.environment_speed)
        print(json.dumps(answer | {"moving": _moving(parameters, limit, rotations)}, indent=2))
    else:
        print(_as_text(parameters, limit, error_bound, found, options.environment_speed))
    return 0


def _parser() -> OneLineParser:
    parser = service_parser("controller.certify")
    parser.description = (
        "Certified approach speed per axis, worst excess for an environment that moves, and what limits them."
    )
    parser.add_argument("--force-limit", default="25", help="[N], one number or x,y,z (default %(default)s)")
    parser.add_argument(
        "--torque-limit", default="10", help="[Nm], one number or x,y,z (default %(default)s)"
    )
    parser.add_argument("--force-error", default="0.6", help="error bound [N] (default %(default)s)")
    parser.add_argument("--torque-error", default="0.1", help="error bound [Nm] (default %(default)s)")
    parser.add_argument("--environment-speed", type=float, default=0.1, help="[m/s] (default %(default)s)")
    parser.add_argument(
        "--orientation",
        action="append",
        metavar="X,Y,Z,W",
        help="with --json: of the tool in base, to print the stiffness bound for; may be repeated (default parallel)",
    )
    parser.add_argument("--json", action="store_true", help="print JSON")
    return parser


def _three(option: str, text: str) -> Array:
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in (1, 3) or not all(0.0 <= number < 1e6 for number in numbers):
        raise Misconfigured(
            f"{option} {text!r}: wanted one number or three, separated by commas, not negative"
        )
    return np.array(numbers * (3 // len(numbers)))


def _rotation(text: str) -> Array:
    try:
        return rotation_matrix([float(part) for part in text.split(",")])
    except ValueError:
        raise Misconfigured(
            f"--orientation {text!r}: wanted a unit quaternion x,y,z,w, separated by commas"
        ) from None


def _moving(parameters: ControllerParameters, limit: Array, rotations: Sequence[Array]) -> dict[str, object]:
    """What the excess in a moving environment follows from, for programs."""
    return {
        "factor": MOVING_FACTOR,
        "response": response(parameters),
        "acceleration": list(parameters.max_acceleration),
        "stiffness": [stiffness(parameters, limit, rotation).tolist() for rotation in rotations],
    }


def _as_map(
    parameters: ControllerParameters,
    limit: Array,
    error_bound: Array,
    found: list[Certificate],
    environment_speed: float,
) -> dict[str, object]:
    return {
        "form": _form(parameters),
        "limit": limit.tolist(),
        "error_bound": error_bound.tolist(),
        "horizon": parameters.horizon,
        "environment_speed": environment_speed,
        "axes": [vars(one) for one in found],
    }


def _form(parameters: ControllerParameters) -> str:
    return "strict" if parameters.yield_start == 1.0 else f"rounded (yield_start {parameters.yield_start:g})"


def _as_text(
    parameters: ControllerParameters,
    limit: Array,
    error_bound: Array,
    found: list[Certificate],
    environment_speed: float,
) -> str:
    lines = [
        f"certified law, {_form(parameters)}; T {parameters.period * 1e3:g} ms, d {parameters.delay * 1e3:g} ms, "
        f"tau {parameters.lag * 1e3:g} ms: a command has acted {parameters.horizon * 1e3:g} ms after its sample",
    ]
    for zone in parameters.contact_zones:
        reach = ", ".join(f"{length:g}" for length in zone.reach)
        lines.append(
            f"contacts up to {zone.stiffness:g} N/m within ({reach}) m of the tool, friction {zone.friction:g}"
        )
    lines += [
        "While environment and base are at rest, no limit is exceeded: from first touch on, between samples too.",
        "",
        f"{'axis':<9} {'limit':>9} {'error':>9}   {'certified approach':<20} {'limited by':<34} "
        f"excess at {environment_speed:g} m/s",
    ]
    for index, one in enumerate(found):
        speed_unit, unit = _UNITS[index // 3]
        speed = f"{one.speed * 1e3:.3g} {speed_unit}"
        share = one.excess / limit[index]
        lines.append(
            f"{one.axis:<9} {limit[index]:>6g} {unit:<2} {error_bound[index]:>6g} {unit:<2}   {speed:<20} "
            f"{one.limited_by:<34} {one.excess:.3g} {unit} ({share:.0%} of the limit)"
        )
    timing = {"period T": parameters.period, "delay d": parameters.delay, "lag tau": parameters.lag}
    name, longest = max(timing.items(), key=lambda item: item[1])
    lines += [
        "",
        f"Speeds scale with 1/(stiffness x {parameters.horizon * 1e3:g} ms); the largest share of the time is the "
        f"{name} ({longest / parameters.horizon:.0%}).",
        f"Excess, measured and not proven: {MOVING_FACTOR:g} x stiffness x speed of the environment x (response time + "
        "time to speed up), beyond the limit, until the tool moves with it.",
    ]
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
