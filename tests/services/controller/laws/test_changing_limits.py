"""Limits, nominal wrench and error bounds that change in contact, in closed loop: no axis passes the limit in force."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.contact import sampling, scripted
from benchmarks.contact.cases import Case, Target
from benchmarks.contact.elastic import Load, Spring, Surface
from benchmarks.contact.laws import CaseLaw, make_law
from benchmarks.contact.robot import Robot
from benchmarks.contact.simulate import simulate
from benchmarks.contact.world import Contact
from services.controller.laws.certified import CertifiedLaw
from services.controller.laws.law import LawInput
from shared.spatial import Array

FORMS = ("certified", "certified-rounded")
SETS = ("soft", "stiff", "soft-clever", "stiff-clever")
LIMIT, LOW = np.repeat((25.0, 10.0), 3), np.repeat((10.0, 0.5), 3)
ERROR = np.repeat((0.3, 0.03), 3)


@dataclass(frozen=True)
class Wish:
    """What a target asks for from ``time`` [s] on: limit, nominal wrench and the sensor's error bound, each (6,)."""

    time: float
    limit: Array
    nominal: Array
    error: Array


class Changing(CaseLaw):
    """The law of a case under changing wishes; keeps when it was asked, what was wished, and what was in force."""

    def __init__(self, form: str, case: Case, wishes: Sequence[Wish]) -> None:
        law = make_law(form, case).law
        assert isinstance(law, CertifiedLaw)
        super().__init__(law, case)
        self.certified, self.wishes = law, wishes
        self.times: list[float] = []
        self.wished: list[Wish] = []
        self.in_force: list[Array] = []
        self.given_way = np.inf  # the time [s] from which on a load that the nominal wrench carried is set down

    def twist(self, wrench: Array, robot: Robot, now: float, dt: float) -> Array:
        wish, target = [one for one in self.wishes if one.time <= now][-1], self.case.target(now)
        output = self.law.step(
            LawInput(
                wrench - wish.nominal, wish.limit, wish.error, robot.position, robot.rotation,
                target.position, target.rotation, wish.nominal,
            ),
            dt,
        )  # fmt: skip
        assert output.failure is None
        if self.certified._yielding.moved and now < self.given_way:
            assert self.certified.caps.shifted, "the environment rests"
            self.given_way = now
        self.times.append(now)
        self.wished.append(wish)
        self.in_force.append(self.law.limit_in_force(wish.limit, wish.nominal))
        return output.twist

    def run(self) -> Array:
        """The true wrench less the nominal one in limits in force (n, 6), as long as the environment rests."""
        trace = simulate(self, keep_trace=True).trace
        assert trace is not None
        wrench = trace.ratio * self.case.limit + self.case.nominal
        tick = np.maximum(np.searchsorted(self.times, trace.times, side="right") - 1, 0)
        share = (wrench - np.array([wish.nominal for wish in self.wished])[tick]) / np.array(self.in_force)[tick]
        return share[trace.times <= self.given_way]

    def reached(self) -> float:
        """Time [s] from the last wish until it was in force for good; infinite if it never was."""
        last = self.wishes[-1]
        late = [k for k, now in enumerate(self.times) if now >= last.time and np.any(self.in_force[k] > last.limit)]
        if not late:
            return 0.0
        return self.times[late[-1] + 1] - last.time if late[-1] + 1 < len(self.times) else np.inf


@settings(max_examples=8, deadline=None)
@given(number=st.integers(0, 10**6), group=st.sampled_from(SETS), form=st.sampled_from(FORMS))
def test_no_axis_passes_the_limit_in_force_whatever_is_wished_when(number: int, group: str, form: str) -> None:
    case, rng = sampling.draw(7, group, number), np.random.default_rng(number)
    wishes = [Wish(0.0, case.limit, case.nominal, case.error_bound)]
    for time in np.sort(rng.uniform(0.2, case.quiet, 3)).tolist():
        error = case.error_bound * rng.choice((1.0, 1.5))
        limit = np.maximum(case.limit * rng.choice((0.05, 0.2, 0.5, 1.0, 1.5), 6), 5.0 * error)
        moved = rng.choice((0.0, 0.0, 1.0)) * case.limit * rng.uniform(-0.6, 0.6, 6)
        wishes.append(Wish(time, limit, case.nominal + moved, error))
    assert np.abs(Changing(form, case, wishes).run()).max() <= 1.0 + 1e-6


def lowered(
    form: str, contacts: tuple[Contact, ...], *targets: Target, limit: Array = LOW, seconds: float = 4.0
) -> Changing:
    """Limits that fall at 1 s; person on a panel, 60 ms in the loop, random errors."""
    case = scripted.still("lowered", contacts, LIMIT, targets or (Target(0.0, np.zeros(3), np.eye(3)),), 1.0 + seconds)
    declared = replace(scripted.declared(500.0, (1.2, 0.3, 0.05), 1.0), max_acceleration=(2.0,) * 3 + (2.5,) * 3)
    timing = replace(scripted.timing(0.01, 0.02, 0.02), declared_period=0.02)
    case = replace(case, error_bound=ERROR, adversary="random", declared=declared, timing=timing)
    nothing = np.zeros(6)
    return Changing(form, case, (Wish(0.0, LIMIT, nothing, ERROR), Wish(1.0, limit, nothing, ERROR)))


@pytest.mark.parametrize("form", FORMS)
def test_with_nothing_touching_a_limit_falls_at_once_and_holds_for_the_contact_that_follows(form: str) -> None:
    """The tool sets out with the change and meets a wall 0.2 s later."""
    wall = Contact(
        np.array((1.0, 0.0, 0.0)), True, Surface(np.array((0.0, 0.0, 1.0)), np.array((1.0, 0.0, -0.001)), 500.0)
    )
    law = lowered(
        form, (wall,), Target(0.0, np.zeros(3), np.eye(3)), Target(1.0, np.array((0.0, 0.0, -0.3)), np.eye(3))
    )
    share = np.abs(law.run())
    assert law.reached() == 0.0
    assert 0.6 < share.max() <= 1.0 + 1e-6


@pytest.mark.parametrize("form", FORMS)
def test_under_way_a_limit_falls_as_soon_as_what_is_in_flight_has_acted(form: str) -> None:
    law = lowered(form, (), Target(0.0, np.array((0.0, 0.0, -3.0)), np.eye(3)))
    law.run()
    assert 0.0 < law.reached() <= 2.0 * law.certified.parameters.horizon


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(
    ("arm", "force"),
    [((0.0, 0.0, 0.0), (0.0, 0.0, -20.0)), ((0.5, 0.2, 0.03), (5.0, 5.0, -8.0))],
    ids=["force", "torque"],
)
def test_what_presses_already_is_in_force_first_and_is_lowered_by_giving_way(
    form: str, arm: tuple, force: tuple
) -> None:
    place = np.array(arm)
    law = lowered(form, (Contact(place, True, Spring(500.0 * np.eye(3), place + np.array(force) / 500.0)),))
    assert np.abs(law.run()).max() <= 1.0 + 1e-6
    at_once = law.in_force[law.times.index(next(now for now in law.times if now >= 1.0))]
    wrench = np.abs(np.concatenate((force, np.cross(place, force))))
    assert np.all(at_once <= np.maximum(LOW, 1.15 * wrench + 5.0 * ERROR)) and np.any(at_once > LOW)
    assert law.reached() <= 4.0


def test_a_weight_that_no_motion_relieves_stays_in_force_and_is_lowered() -> None:
    law = lowered("certified-rounded", (Contact(np.zeros(3), True, Load(np.array((0.0, 0.0, -15.0)))),))
    assert np.abs(law.run()).max() <= 1.0
    assert law.reached() == np.inf and 15.0 < law.in_force[-1][2] < 18.0
    assert law.law.twist[2] < -1e-3


@pytest.mark.parametrize("form", FORMS)
def test_a_weight_in_hand_is_set_down_although_another_axis_has_no_room(form: str) -> None:
    """The nominal wrench that carried it fades away; a torque that lasts is at its cap, below the wall."""
    law = lowered(form, ()).certified
    limit, nominal = np.repeat((10.0, 3.0), 3), np.array((0.0, 0.0, -12.0, 0.0, 0.0, 0.0))
    law.caps.update(limit, ERROR)
    torque = law.caps._cap[4] + law.caps.errors[4]
    sank = []
    for tick in range(600):
        wrench = np.array((0.0, 0.0, -16.5, 0.0, -torque * min(1.0, 0.02 * tick), 0.0))
        if tick > 100:
            nominal = np.array((0.0, 0.0, min(0.0, -12.0 + 0.05 * (tick - 100)), 0.0, 0.0, 0.0))
        pose = np.zeros(3), np.eye(3)
        twist = law.step(LawInput(wrench - nominal, limit, ERROR, *pose, *pose, nominal), 0.01).twist
        sank.append(-twist[2])
    assert min(sank[-100:]) > 0.01
