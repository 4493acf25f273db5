"""Draws the random cases of the contact benchmark, one set after the other.

A case is a function of the seed, the set's name and its number only, so each one can be repeated alone.
"""

from __future__ import annotations

import math
import zlib
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.contact.adversary import CLEVER, KINDS
from benchmarks.contact.cases import Case, Declared, Target, Timing
from benchmarks.contact.elastic import ElasticLaw, Load, Spring, Surface
from benchmarks.contact.world import Contact, World
from shared.spatial import Array, rotation_from_vector

RATES = (30.0, 100.0, 250.0, 1000.0)
_LIMITS = (np.array((10.0, 10.0, 10.0, 0.5, 3.0, 3.0)), np.array((25.0, 25.0, 25.0, 10.0, 10.0, 10.0)))
_STRONG = (40.0,) * 3 + (80.0,) * 3


@dataclass(frozen=True)
class Group:
    """A set of random cases.

    Attributes:
        stiffness: declared sum over the contacts, lowest and highest, drawn evenly on a logarithmic scale [N/m].
        reach: largest lever arm [m]; drawn from a twentieth of it, evenly on a logarithmic scale.
        true_share: the least share of the declared stiffness that is really there.
        travel: targets lie this far from the start [m].
        turn: and are turned by this much [rad].
        speed: of the environment [m/s].
        clever: whether every case has an adversary that knows the contact.
        rates: control rates and how often each is drawn [Hz].
    """

    stiffness: tuple[float, float]
    reach: float
    true_share: float
    travel: float
    turn: float
    speed: float = 0.0
    clever: bool = False
    rates: tuple[tuple[float, float], ...] = ((30.0, 0.34), (100.0, 0.42), (250.0, 0.2), (1000.0, 0.04))


GROUPS: dict[str, Group] = {
    "stiff": Group((1e2, 1.5e5), 1.2, 0.9, 0.2, 0.5),
    "soft": Group((50.0, 2000.0), 0.5, 0.3, 0.4, 0.8),
    "soft-clever": Group((50.0, 2000.0), 0.5, 0.9, 0.4, 0.8, clever=True),
    "stiff-clever": Group((1e2, 1.5e5), 0.6, 0.95, 0.2, 0.5, clever=True),
    "moving-0.1": Group((100.0, 2000.0), 0.5, 0.5, 0.2, 0.3, speed=0.1),
    "moving-0.2": Group((100.0, 2000.0), 0.5, 0.5, 0.2, 0.3, speed=0.2),
    "moving-0.1-far": Group((100.0, 2000.0), 1.2, 0.5, 0.2, 0.3, speed=0.1),
    "moving-0.2-far": Group((100.0, 2000.0), 1.2, 0.5, 0.2, 0.3, speed=0.2),
}


def draw(seed: int, name: str, number: int) -> Case:
    """Case ``number`` of the set ``name``."""
    group = GROUPS[name]
    rng = np.random.default_rng((seed, zlib.crc32(name.encode()), number))
    position, rotation = rng.uniform(-0.5, 0.5, 3), rotation_from_vector(rng.normal(size=3))
    limit = _LIMITS[int(rng.integers(2))].copy()
    error = rng.uniform(0.0, 1.0) * np.repeat((1.5, 0.1), 3)
    declared_stiffness = float(np.exp(rng.uniform(*np.log(group.stiffness))))
    true_stiffness = declared_stiffness * rng.uniform(group.true_share, 1.0)
    reach = np.exp(rng.uniform(math.log(0.05), 0.0, 3)) * group.reach
    drawn = [
        _contact(rng, position, rotation, reach, share * true_stiffness)
        for share in rng.dirichlet(np.full(int(rng.integers(1, 4)), 3.0))
    ]
    contacts, nominal = _start_within(drawn, position, rotation, limit, rng)
    friction = max((c.law.friction for c in contacts if isinstance(c.law, Surface)), default=0.0)
    timing = _timing(rng, group)
    quiet = 1.6 if timing.period > 0.005 or group.speed > 0.0 else 1.0
    times, shift = _environment(rng, group.speed, quiet)
    declared = Declared(
        contact_stiffness=declared_stiffness,
        contact_reach=_declared_reach(drawn, position, rotation, rng),
        contact_friction=friction,
        relaxation_weight=1.0 if group.speed > 0.0 else float(rng.choice((1.0, 5.0, 20.0))),
        max_linear=0.25,
        max_angular=float(rng.choice((0.5, 1.0))),
        max_acceleration=(2.0, 2.0, 2.0, 2.5, 1.0, 1.0) if rng.random() < 0.3 else _STRONG,
    )
    return Case(
        group=name,
        seed=int(rng.integers(2**31)),
        position=position,
        rotation=rotation,
        contacts=contacts,
        limit=limit,
        error_bound=np.minimum(error, limit / 4.0),
        nominal=nominal,
        timing=timing,
        declared=declared,
        adversary=str(rng.choice(CLEVER if group.clever else KINDS)),
        targets=_targets(rng, group, position, rotation, quiet),
        shift_times=times,
        shift=shift,
        quiet=quiet,
        duration=quiet + 0.8,
    )


def _declared_reach(
    contacts: list[Contact], position: Array, rotation: Array, rng: np.random.Generator
) -> tuple[float, float, float]:
    """The box around all contacts with up to 30 % and a centimetre to spare."""
    arms = [c.point if c.carried else rotation.T @ (c.point - position) for c in contacts]
    x, y, z = (np.abs(arms).max(axis=0) * rng.uniform(1.0, 1.3) + 0.01).tolist()
    return x, y, z


def _timing(rng: np.random.Generator, group: Group) -> Timing:
    rates, weights = zip(*group.rates, strict=True)
    period = 1.0 / float(rng.choice(rates, p=weights))
    jitter = 0.2
    longest = rng.uniform(0.0, 0.03)
    delay = longest * rng.uniform(0.5, 1.0), longest
    latency, lag = rng.uniform(0.0, 0.01), rng.choice((0.0, 1.0)) * rng.uniform(0.002, 0.02)
    margin = rng.uniform(1.0, 1.5)
    return Timing(
        period=period,
        jitter=jitter,
        delay=delay,
        latency=latency,
        lag=lag,
        declared_period=max(1e-3, period * (1.0 + jitter) + delay[1] - delay[0]),
        declared_delay=(longest + latency) * margin,
        declared_lag=lag * margin,
    )


def _contact(rng: np.random.Generator, position: Array, rotation: Array, reach: Array, stiffness: float) -> Contact:
    """A contact within 0.9 of the reach, of any kind, at most a few newtons from touching."""
    carried = bool(rng.random() < 0.5)
    arm = rng.uniform(-0.9, 0.9, 3) * reach
    base = position + rotation @ arm
    point, here = (arm, base) if carried else (base, arm)
    offset = min(rng.exponential(4.0) / stiffness, 0.05)
    normal = rng.normal(size=3)
    normal /= np.linalg.norm(normal)
    kind = rng.random()
    law: ElasticLaw
    if kind < 0.2:
        law = Spring(stiffness * np.eye(3), here + normal * offset)
    elif kind < 0.5:
        axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        values = stiffness * np.array((1.0, *(rng.random(2) * rng.choice((0.0, 1.0), 2))))
        law = Spring(axes @ np.diag(values) @ axes.T, here + normal * offset)
    else:
        friction = float(rng.choice((0.0, 1.0)) * rng.uniform(0.1, 0.6))
        depth = offset * rng.choice((-1.0, 1.0))
        sticking = stiffness * rng.uniform(0.3, 1.0)
        law = Surface(normal, here + normal * depth, stiffness, sticking, friction, bool(rng.random() < 0.4))
    return Contact(point, carried, law)


def _start_within(
    contacts: list[Contact], position: Array, rotation: Array, limit: Array, rng: np.random.Generator
) -> tuple[tuple[Contact, ...], Array]:
    """The contacts, shifted until the start is within 0.6 of the limits; one in ten cases also carries a load."""
    pose = position[None], rotation[None], np.zeros((1, 3))

    def wrench() -> Array:
        return World(tuple(contacts), position, rotation).advance(*pose)[0]

    while np.max(np.abs(wrench()) / limit) > 0.6:
        contacts = [_relaxed(contact, position, rotation) for contact in contacts]
    if rng.random() > 0.1:
        return tuple(contacts), np.zeros(6)
    empty = wrench()
    contacts.append(Contact(rng.uniform(-0.05, 0.05, 3), True, Load(np.array((0.0, 0.0, -rng.uniform(1.0, 10.0))))))
    return tuple(contacts), wrench() - empty


def _relaxed(contact: Contact, position: Array, rotation: Array) -> Contact:
    """The same contact with half the deflection."""
    law = contact.law
    base = position + rotation @ contact.point if contact.carried else rotation.T @ (contact.point - position)
    if isinstance(law, Spring):
        return replace(contact, law=replace(law, rest=(law.rest + base) / 2.0))
    assert isinstance(law, Surface)
    return replace(contact, law=replace(law, origin=(law.origin + base) / 2.0))


def _targets(
    rng: np.random.Generator, group: Group, position: Array, rotation: Array, quiet: float
) -> tuple[Target, ...]:
    def somewhere(time: float) -> Target:
        turn = rotation_from_vector(rng.uniform(-1.0, 1.0, 3) * group.turn)
        return Target(time, position + rng.uniform(-1.0, 1.0, 3) * group.travel, turn @ rotation)

    return tuple(somewhere(time) for time in np.linspace(0.0, quiet, 4)[:3])


def _environment(rng: np.random.Generator, speed: float, quiet: float) -> tuple[Array, Array]:
    """Way points of an environment that rests, moves straight, turns once, and stops when it gets quiet."""
    times = np.array((0.0, 0.2, 0.2 + (quiet - 0.2) * rng.uniform(0.4, 0.6), quiet))
    steps = np.zeros((4, 3))
    for leg in (2, 3):
        direction = rng.normal(size=3)
        steps[leg] = direction / np.linalg.norm(direction) * speed * (times[leg] - times[leg - 1])
    return times, np.cumsum(steps, axis=0)
