"""The contact benchmark's cases, adversaries and measurements, and that it finds a law that is wrong."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.contact import scripted
from benchmarks.contact.adversary import CLEVER, KINDS, Adversary
from benchmarks.contact.elastic import Surface
from benchmarks.contact.laws import make_law
from benchmarks.contact.measure import OVER, Job, plan, run_job
from benchmarks.contact.robot import Robot
from benchmarks.contact.sampling import GROUPS, draw
from benchmarks.contact.simulate import _turning_points, simulate
from benchmarks.contact.world import World
from services.controller.bounds.stiffness_bound import ContactZone, StiffnessBound
from shared.spatial import rotation_from_vector

LIMIT = np.array((10.0, 10.0, 10.0, 0.5, 3.0, 3.0))


@pytest.mark.parametrize("group", GROUPS)
def test_cases_are_within_what_they_declare(group: str) -> None:
    for number in range(25):
        case = draw(3, group, number)
        world = World(case.contacts, case.position, case.rotation)
        wrench = world.advance(case.position[None], case.rotation[None], np.zeros((1, 3)))[0]
        assert np.max(np.abs(wrench - case.nominal) / case.limit) <= 0.7
        assert np.all(world.reach <= case.declared.contact_reach)
        total = sum(contact.law.stiffness for contact in case.contacts)
        assert total <= case.declared.contact_stiffness * (1 + 1e-9)
        for contact in case.contacts:
            if isinstance(contact.law, Surface):
                assert contact.law.friction <= case.declared.contact_friction
        assert np.all(case.limit > 3.0 * case.error_bound)
        timing = case.timing
        assert timing.period * (1 + timing.jitter) + timing.delay[1] - timing.delay[0] <= timing.declared_period
        assert timing.delay[1] + timing.latency <= timing.declared_delay
        assert case.at_rest == (GROUPS[group].speed == 0.0)


def test_a_case_depends_on_its_number_alone() -> None:
    first, second = (run_job(Job(5, "soft", 2, ("certified",)))[0].result for _ in range(2))
    assert first == second
    assert draw(5, "soft", 3).seed != draw(5, "soft", 2).seed
    assert len({(job.group, job.number) for job in plan(0, 100)}) == len(plan(0, 100))


def test_tangents_along_random_motions_are_within_the_controllers_bound() -> None:
    """The true tangent, geometry of the present forces included, against Kbar = E + G."""
    rng = np.random.default_rng(0)
    closest = 0.0
    for number in range(120):
        case = draw(7, ("soft", "stiff")[number % 2], number)
        world = World(case.contacts, case.position, case.rotation)
        robot = Robot(case.position, case.rotation, 0.0)
        robot.command(0.0, rng.normal(size=6) * 1e-3, 1.0)
        path = robot.advance(0.0, 1.0, 0.05)
        world.advance(path.positions, path.rotations, np.zeros((len(path.times), 3)))
        declared = case.declared
        bound = StiffnessBound(
            [ContactZone(declared.contact_stiffness, declared.contact_reach, declared.contact_friction)]
        )
        force = np.maximum(world.squeeze, 1e-9)
        bound.update(robot.rotation, 0.0, force.tolist())
        tangent = world.stiffness(robot.position, robot.rotation, np.zeros(3))
        assert np.all(np.abs(tangent) <= bound.matrix * (1 + 1e-4) + 1e-3)
        assert np.all(tangent.diagonal() >= -bound.low - 1e-3 - 1e-4 * bound.matrix.diagonal())
        closest = max(closest, float((np.abs(tangent) / bound.matrix).max()))
    assert closest > 0.5, "some contact has to come close, or the bound is not tested"


@pytest.mark.parametrize("kind", KINDS)
def test_errors_stay_within_their_bound(kind: str) -> None:
    rng = np.random.default_rng(1)
    bound = np.array((0.5, 0.4, 0.3, 0.0, 0.02, 0.01))
    adversary = Adversary(kind, bound, LIMIT, rng)
    stiffness = np.eye(6) * 1000.0 if kind in CLEVER else None
    for _ in range(100):
        error = adversary.error(LIMIT * rng.uniform(-1, 1, 6), stiffness)
        assert np.all(np.abs(error) <= bound)
        assert np.array_equal(adversary.hold(), error)


def test_the_adversary_hides_the_worst_axis_and_turns_yielding_against_it() -> None:
    bound = np.full(6, 0.1)
    stiffness = np.zeros((6, 6))
    stiffness[0, 1] = stiffness[1, 0] = -500.0
    stiffness[0, 2] = stiffness[2, 0] = 500.0
    wrench = np.array((9.0, 8.0, 8.0, 0.0, 0.0, 0.0))
    error = Adversary("axis", bound, LIMIT, np.random.default_rng(0)).error(wrench, stiffness)
    assert error[0] == -0.1, "the worst axis looks smaller"
    assert error[1] == 0.1, "yielding along y raises the force along x: y looks larger"
    assert error[2] == -0.1


def test_swings_are_counted_and_slow_changes_are_not() -> None:
    time = np.linspace(0.0, 1.0, 500)
    assert _turning_points(np.sin(2 * np.pi * 5 * time)) in (9, 10)
    assert _turning_points(0.04 * np.sin(2 * np.pi * 5 * time)) == 0
    assert _turning_points(time) == 0


@pytest.mark.parametrize("law", ["certified", "certified-rounded"])
@pytest.mark.parametrize("number", [1, 4, 7])
def test_certified_law_keeps_the_limits_where_the_papers_does_not(law: str, number: int) -> None:
    case = replace(draw(0, "stiff", number), quiet=0.6, duration=1.0)
    assert simulate(make_law(law, case)).peak <= OVER


def test_the_papers_law_breaks_a_limit_in_a_stiff_contact() -> None:
    case = replace(draw(0, "stiff", 1), quiet=0.6, duration=1.0)
    assert simulate(make_law("paper", case)).peak > 1.5


def test_a_bound_that_is_too_small_is_found_out() -> None:
    """The benchmark must be able to fail: the same wall, declared twenty times too soft."""
    case = replace(
        scripted.wall("slide", scripted.WALL_STIFFNESS), timing=scripted.timing(0.01, 0.02), duration=1.5, quiet=1.0
    )
    too_soft = replace(case, declared=replace(case.declared, contact_stiffness=scripted.WALL_STIFFNESS / 20.0))
    assert simulate(make_law("certified", case)).peak <= OVER
    assert simulate(make_law("certified", too_soft)).peak > OVER


def test_the_robot_of_the_world_turns_as_commanded() -> None:
    robot = Robot(np.zeros(3), np.eye(3), 0.01)
    robot.command(0.0, np.array((0.0, 0.0, 0.0, 0.0, 0.0, 1.0)), 0.5)
    robot.advance(0.0, 2.0, 0.002)
    np.testing.assert_allclose(robot.rotation, rotation_from_vector((0.0, 0.0, 0.5)), atol=1e-9)


@pytest.mark.parametrize("number", [12, 13, 18, 19, 48, 49, 54, 55, 84, 85, 90, 91])
def test_a_pull_on_the_hardest_lever_calms_down(number: int) -> None:
    """As stiff as declared, across the axis with the smallest limit, and with nothing to spare in time."""
    job = Job(0, "steady pull", number, ("certified-rounded", "paper"))
    case = job.case()
    assert case.contacts[0].law.stiffness == pytest.approx(case.declared.contact_stiffness)
    ours, theirs = (row.result for row in run_job(job))
    assert not ours.sustained
    assert ours.peak < 0.7 * theirs.peak


def test_room_that_comes_back_does_not_make_the_tool_hunt() -> None:
    """Pressed obliquely on a stiff spring under delay, it once moved to and fro while it crept to its target."""
    for row in run_job(Job(0, "stiff-clever", 22, ("certified", "certified-rounded"))):
        assert not row.result.sustained and row.result.swing[1] < 0.5
        assert row.result.peak <= OVER and row.result.travelled > 0.01
