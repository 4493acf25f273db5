"""What the certified law allows beyond its limits while its environment moves (docs/guarantee.md).

The stiffness bound and the response time are the controller's. They are asked for as a user would, with
`python -m services.controller.certify`: services never import each other.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

PATIENCE = 60.0  # [s] for the answer


@dataclass(frozen=True)
class Certified:
    """What `certify` says of a controller's configuration.

    Attributes:
        factor: peak of the excess over what the stiffness bound lets the wrench grow by; measured, not proven.
        response: time [s] from a sample until the answer to it has acted.
        acceleration: (6,) [m/s2, rad/s2] of the tool when it speeds up.
        attitudes: (k, 4) of the tool in base, for which there is
        stiffness: Kbar (k, 6, 6), in base axes [N/m, N/rad, Nm/m, Nm/rad].
    """

    factor: float
    response: float
    acceleration: np.ndarray
    attitudes: np.ndarray
    stiffness: np.ndarray

    def excess(self, twist: np.ndarray, attitude: np.ndarray) -> np.ndarray:
        """Expected worst excess (n, 6) [N, Nm] over the limits.

        ``factor * sum_j Kbar_ij |u_j| (D + |u_j| / 2 a_j)``: the growth until the tool can have followed.

        Args:
            twist: |u| (n, 6) [m/s, rad/s] of the environment relative to the base, at the tool's origin.
            attitude: (n,) which of `attitudes` the tool has.
        """
        travel = twist * (self.response + twist / (2.0 * self.acceleration))
        return self.factor * np.einsum("nij,nj->ni", self.stiffness[attitude], travel)


Certify = Callable[[Mapping[str, Any], Sequence[float], Sequence[float], np.ndarray], Certified]
"""As `certified` below."""


def certified(
    settings: Mapping[str, Any], limit: Sequence[float], error: Sequence[float], attitudes: np.ndarray
) -> Certified:
    """Asks for the configuration of a controller.

    Args:
        settings: its parameters that differ from the defaults.
        limit: (6,) [N, Nm].
        error: (6,) bound on the wrench's error.
        attitudes: (k, 4) of the tool in base that are of interest.

    Raises:
        ValueError: it has none to give; the text says why.
    """
    command = [sys.executable, "-m", "services.controller.certify", "--json"]
    # JSON's numbers, lists and strings are TOML's too.
    command += [part for name, value in settings.items() for part in ("--set", f"{name}={json.dumps(value)}")]
    for option, values in (
        ("--force-limit", limit[:3]),
        ("--torque-limit", limit[3:]),
        ("--force-error", error[:3]),
        ("--torque-error", error[3:]),
    ):
        command += [option, ",".join(map(repr, map(float, values)))]
    for attitude in attitudes:
        command.append("--orientation=" + ",".join(map(repr, map(float, attitude))))
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE, check=False)
    except subprocess.TimeoutExpired:
        raise ValueError(f"services.controller.certify took over {PATIENCE:.0f} s") from None
    if done.returncode:
        said = (done.stderr.strip() or "it said nothing").splitlines()[-1]
        raise ValueError(f"services.controller.certify ended with status {done.returncode}: {said}")
    answer = json.loads(done.stdout)
    moving = answer["moving"]
    return Certified(
        factor=moving["factor"],
        response=moving["response"],
        acceleration=np.array(moving["acceleration"]),
        attitudes=attitudes,
        stiffness=np.array(moving["stiffness"]),
    )
