"""What a reader of the carry's page has to know to judge its claims."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from services.experiment.carry.carry_measures import Measures
from services.experiment.carry.effort import HARD_TORQUE
from services.experiment.carry.excess import AFTER, AXES, BEFORE, REST_SPEED, REST_TURNING


def notes(measured: Mapping[str, Measures]) -> list[str]:
    """One line each."""
    return [
        "The limits are promised while the person and the base rest: while the hands move at most "
        f"{1e3 * REST_SPEED:.0f} mm/s and {REST_TURNING:g} rad/s relative to the base. While they move, nothing can "
        "keep a limit by itself; the excess that the motion accounts for is c |Kbar u| (D + u/2a), axis by axis, with "
        "c, Kbar, D and a as `tandem certify` has them. c is measured, not proven.",
        "u is the motion of the person's hands as the simulation knows it, relative to the base and taken at the tool, "
        f"in all six directions, the fastest from {BEFORE:g} s before a sample to {AFTER:g} s after it. What the base "
        "moves is in it: a person with whom the base keeps pace does not move relative to it.",
        *(_allowance(name, found) for name, found in measured.items() if np.isfinite(found.excess.used)),
        "This allowance is wide, because a torque limit of 0.5 Nm is small and a panel long: hardly any law would use "
        "it up, so nothing is claimed about it. That the excess is small is what the shares of the time over one and "
        "over one and a half limits show.",
        *(_effort(name, found) for name, found in measured.items()),
        f"Lowering the robot's end takes more than {HARD_TORQUE:g} Nm of the person's hands for seconds, under every "
        "law: the robot gives way to a torque, and the person stands at the far end. That is more than anybody "
        "likes to give for long; the simulated person has 20 Nm.",
        "Panel, hands and ground are the simulation's own account (sim/world); the rest is measured as on a robot.",
    ]


def _allowance(name: str, found: Measures) -> str:
    excess = found.excess
    speed, turning = excess.fastest
    axes = ", ".join(
        f"{axis} {peak:.2f} of {allowed:.1f}"
        for axis, peak, allowed in zip(AXES, excess.peaks, excess.allowed, strict=True)
    )
    return (
        f"{name}: hands at up to {speed:.2f} m/s and {turning:.2f} rad/s relative to the base. Of the excess that they "
        f"account for, {100 * excess.used:.0f} % was found at most. Largest, in limits: {axes}."
    )


def _effort(name: str, found: Measures) -> str:
    it = found.effort
    return (
        f"{name}: hands at most {it.force:.1f} N ({it.guiding_force:.1f} N horizontally while guiding) and "
        f"{it.torque:.1f} Nm (over {HARD_TORQUE:g} Nm for {it.hard:.1f} s); work {it.guiding:.1f} J of guiding; in all "
        f"{it.work:.1f} J, of which half of the weight {it.lifting:.1f} J, since the panel ends lower than it began. "
        f"Over a limit {100 * found.excess.over:.1f} % of the time ({100 * found.excess.surely_over:.1f} % for sure), "
        f"at most {max(found.excess.peaks):.2f} limits; some limit shaped the motion {100 * found.active:.0f} % of "
        "the time."
    )
