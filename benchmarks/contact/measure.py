"""Every law through every case, over several processes, and what the results are summed up to."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass

from benchmarks.contact import scripted
from benchmarks.contact.cases import Case
from benchmarks.contact.laws import LAWS, make_law
from benchmarks.contact.sampling import GROUPS, draw
from benchmarks.contact.simulate import Result, simulate

OVER = 1.0005
"""A peak counts as over the limit from here on: what the simulation's own rounding leaves open."""

_RECORDED = (
    *("peak", "axis", "time", "travelled", "turned", "missing"),
    *("swing", "turns", "sustained", "within_reach", "within_squeeze"),
)
"""Columns of the CSV that are the result's."""
SCRIPTED = {
    "oblique spring": scripted.oblique_spring,
    "turning face": scripted.turning_face,
    "steady pull": scripted.steady_pull,
}


@dataclass(frozen=True)
class Job:
    """One case to run with some laws."""

    seed: int
    group: str
    number: int
    laws: tuple[str, ...] = LAWS

    def case(self) -> Case:
        """The case that this is about."""
        if self.group in SCRIPTED:
            return SCRIPTED[self.group](self.number)
        return draw(self.seed, self.group, self.number)


@dataclass(frozen=True)
class Row:
    """One law in one case."""

    job: Job
    law: str
    rate: float
    adversary: str
    at_rest: bool
    result: Result
    ticks: int
    failures: tuple[str, ...]

    @property
    def over(self) -> bool:
        """Whether the wrench exceeded a limit."""
        return self.result.peak > OVER

    def record(self) -> dict[str, object]:
        """Flat and plain, for the CSV: lengths in metres, peaks in limits."""
        job = {"set": self.job.group, "number": self.job.number, "seed": self.job.seed, "law": self.law}
        job |= {"rate_hz": round(self.rate, 3), "adversary": self.adversary}
        found = {name: getattr(self.result, name) for name in _RECORDED}
        return {**job, **found, "ticks": self.ticks, "solver_failures": len(self.failures)}


def run_job(job: Job) -> list[Row]:
    """All laws of one job."""
    case = job.case()
    rows = []
    for name in job.laws:
        law = make_law(name, case)
        result = simulate(law)
        rate, failures = 1.0 / case.timing.period, tuple(law.failures)
        rows.append(Row(job, name, rate, case.adversary, case.at_rest, result, law.ticks, failures))
    return rows


def run_all(jobs: list[Job], processes: int) -> Iterator[list[Row]]:
    """Rows of all jobs, in their order, computed by ``processes`` processes."""
    if processes <= 1:
        yield from map(run_job, jobs)
        return
    with ProcessPoolExecutor(processes) as pool:
        yield from pool.map(run_job, jobs, chunksize=4)


def plan(seed: int, cases: int) -> list[Job]:
    """About ``cases`` random cases over all sets, and the scripted ones; sets that move weigh half."""
    weights = {name: 2 if group.speed == 0.0 else 1 for name, group in GROUPS.items()}
    share = cases / sum(weights.values())
    jobs = [Job(seed, name, number) for name, weight in weights.items() for number in range(round(share * weight))]
    every = max(1, round(2000 / cases))
    jobs += [Job(seed, "oblique spring", number) for number in range(0, 240, every)]
    jobs += [Job(seed, "turning face", number) for number in range(0, 40, every)]
    jobs += [Job(seed, "steady pull", number) for number in range(0, 108, every)]
    return jobs


def shuffled(jobs: list[Job]) -> list[Job]:
    """The jobs in a fixed mixed order, so that slow sets spread over the processes."""
    return sorted(jobs, key=lambda job: zlib.crc32(f"{job.group}:{job.number}".encode()))
