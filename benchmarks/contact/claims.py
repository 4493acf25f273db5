"""What has to hold of the certified law, judged from the runs."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from benchmarks.contact import scripted
from benchmarks.contact.cases import Case
from benchmarks.contact.laws import make_law, parameters
from benchmarks.contact.measure import OVER, Row
from benchmarks.contact.report import Claim
from benchmarks.contact.sampling import GROUPS
from benchmarks.contact.simulate import Result, simulate
from services.controller.bounds.caps import AXES
from services.controller.guarantee import certificates

STRICT, ROUNDED = "certified", "certified-rounded"
FORMS = {STRICT: "strict", ROUNDED: "rounded"}
_REALLY_MOVES = 0.03  # [m], half of the runs with soft contacts have to travel more
_SLIDES = {1.0: 0.15, 5.0: 0.05}  # [m] along the wall, by how many times stiffer it is declared than it is
_RETREAT_MISSES = 0.005  # [m]


def from_rows(rows: list[Row]) -> list[Claim]:
    """Claims about the random and scripted cases."""
    claims = []
    for law, form in FORMS.items():
        rest = [row for row in rows if row.law == law and row.at_rest]
        claims.append(_within(f"{form}: within every limit, environment at rest", rest))
        clever = [row for row in rest if row.adversary in ("axis", "potential")]
        claims.append(_within(f"{form}: the same, with an adversary that knows the contact", clever))
        every = [row for row in rows if row.law == law]
        swinging = [row for row in every if row.result.sustained]
        claims.append(
            Claim(
                f"{form}: nothing oscillates without decaying",
                f"{len(swinging)} of {len(every)} runs{_named(swinging)}",
                bool(every) and not swinging,
            )
        )
        soft = [row.result.travelled for row in rest if row.job.group.startswith("soft")]
        moved = float(np.median(soft)) if soft else 0.0
        claims.append(
            Claim(f"{form}: soft contacts really move the tool", f"median {moved * 1e3:.0f} mm", moved > _REALLY_MOVES)
        )
    return [*claims, _solver(rows), *_against_paper(rows)]


def _solver(rows: list[Row]) -> Claim:
    """A failed solve brakes for one tick, which is safe, but has to be rare."""
    ticks = sum(row.ticks for row in rows)
    failures = [failure for row in rows for failure in row.failures]
    reasons = f": {', '.join(sorted(set(failures)))}" if failures else ""
    text = "the solver fails in fewer than 1 of 10,000 ticks, and every failure brakes"
    return Claim(text, f"{len(failures)} of {ticks:,}{reasons}", len(failures) < 1e-4 * ticks)


def _within(text: str, rows: list[Row]) -> Claim:
    over = [row for row in rows if row.over]
    highest = max((row.result.peak for row in rows), default=math.nan)
    covered = sum(row.result.covered for row in rows)
    measured = f"{len(over)} of {len(rows)} over {OVER:g} ({covered} inside every assumption), max {highest:.4f}"
    return Claim(text, measured + _named(over), bool(rows) and not over)


def _named(rows: list[Row]) -> str:
    if not rows:
        return ""
    shown = ", ".join(f"{row.job.group}:{row.job.number} (seed {row.job.seed})" for row in rows[:10])
    return f": {shown}{', ...' if len(rows) > 10 else ''}"


def _against_paper(rows: list[Row]) -> list[Claim]:
    claims = []
    for speed in (0.1, 0.2):
        names = [name for name, group in GROUPS.items() if group.speed == speed]
        ours, theirs = (
            np.array([row.result.peak for row in rows if row.law == law and row.job.group in names])
            for law in (ROUNDED, "paper")
        )
        for quantile, word in ((0.5, "median"), (0.95, "95th percentile")):
            text = f"rounded: {word} of the peak below the paper's law, environment at {speed} m/s, to 2 kN/m"
            if len(ours) == 0 or len(theirs) == 0:
                claims.append(Claim(text, "not measured", False))
                continue
            a, b = float(np.quantile(ours, quantile)), float(np.quantile(theirs, quantile))
            claims.append(Claim(text, f"{a:.2f} against {b:.2f} limits", a < b))
    return claims


def walls() -> list[Claim]:
    """Presses a wall, slides along it, and retreats from it."""
    claims = []
    for law, form in FORMS.items():
        for factor, least in _SLIDES.items():
            declared = factor * scripted.WALL_STIFFNESS
            slide, retreat = (_run(law, scripted.wall(action, declared)) for action in ("slide", "retreat"))
            slid = scripted.WALL_TRAVEL["slide"] - abs(slide.offset[1])
            claims.append(
                Claim(
                    f"{form}: slides along and retreats from a wall of 2000 N/m declared as {declared:g}",
                    f"slid {slid * 1e3:.0f} mm of 200, missing {retreat.missing * 1e3:.1f} mm of the retreat, "
                    f"peak {max(slide.peak, retreat.peak):.3f}",
                    slid >= least and retreat.missing <= _RETREAT_MISSES and max(slide.peak, retreat.peak) <= OVER,
                )
            )
    return claims


def approaches() -> list[Claim]:
    """Free-space speed against the certified speed, the least over all axes, for both forms."""
    claims = []
    for law, form in FORMS.items():
        for name in scripted.APPROACHES:
            worst, where = math.inf, ""
            for period in (0.036, 0.012, 0.0048):
                for axis in range(6):
                    share = _approach(law, name, period, axis)
                    if share < worst:
                        worst, where = share, f"{AXES[axis]}, T {period * 1e3:g} ms"
            text = f"{form}: approaches at 90 % or more of the certified speed, {name}"
            claims.append(Claim(text, f"at least {worst:.1%} ({where})", worst >= 0.9))
    return claims


def _run(law: str, case: Case) -> Result:
    return simulate(make_law(law, case))


def _approach(law: str, name: str, period: float, axis: int) -> float:
    """Speed reached along one axis, as a share of the certified one.

    Turning is measured at its beginning, because the certificate is about a tool whose axes are parallel to the base's.
    """
    case = scripted.approach(name, period, axis)
    paths, times = [], []
    for duration in (1.0, 1.5) if axis < 3 else (0.015, 0.035 + period):
        result = simulate(make_law(law, replace(case, duration=duration, quiet=0.0)), keep_trace=True)
        assert result.trace is not None
        paths.append(result.travelled if axis < 3 else result.turned)
        times.append(float(result.trace.times[-1]))
    certificate = certificates(parameters(law, case), case.limit, case.error_bound)[axis]
    return (paths[1] - paths[0]) / (times[1] - times[0]) / certificate.speed
