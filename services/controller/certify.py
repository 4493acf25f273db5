"""``python -m services.controller.certify``: what the certified law guarantees with a configuration."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence

import numpy as np

from services.controller.guarantee import as_map, as_text
from services.controller.parameters import ControllerParameters
from shared.loop.config import Misconfigured, OneLineParser, complain, service_parameters, service_parser
from shared.spatial import Array, rotation_matrix

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
        given = parameters, limit, error_bound, options.environment_speed
        text = json.dumps(as_map(*given, rotations), indent=2) if options.json else as_text(*given)
    except (Misconfigured, ValueError) as problem:
        return complain("certify", problem)
    print(text)
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


if __name__ == "__main__":
    sys.exit(main())
