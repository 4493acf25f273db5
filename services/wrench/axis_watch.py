"""One axis of the force-torque sensor: the value it has, for how long, and what it was like while it lived.

scale
    Size of a change by noise alone. Where readings go up and down in turns, motion adds to one of two changes at most:
    the smaller of both counts.
noisy
    Readings go up and down in turns, as noise does and motion does not, by more than their steps q.
p
    Share of readings that repeated the one before (two standard deviations above what was seen); on a grid of steps q
    at least erf(q / (sqrt(2 pi) scale)): normal noise, mid-step.
dead zone
    The axis repeated a value, has been back there since, and has never been near it but exactly there: `gap` is how
    near, the zone is no wider. A cable that loses contact does the same, so noise that ends there is no fault only if
    the axis had rested there before anything was known of its noise, as at the start.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

RESOLUTION = 1e-9  # [N, Nm] between equal readings: a living sensor's noise is far above, rounding below
FEWEST_REPEATS = 2  # at 30 Hz no more than this fits into 0.1 s
CHANCE = 1e-9  # of as many repeats in a living axis
FEWEST_READINGS, REMEMBERED = 20, 1000  # readings by which an axis is known; beyond so many the old ones fade
RESTED = 5  # repeats of a value that may be that of a dead zone, while noise is not known
LEAST_TURNS = 0.2  # share of changes that go back: white noise 2/3, a first-order low pass 1/2, motion next to none
LEAST_CHANGES = 0.5  # share of readings that change
LEAST_SPREAD = 1.5  # steps in a change by noise: below it p depends on where within a step the load lies
PER_SMALLER = 1.2  # mean change of white noise per mean of the smaller of two: 1.33, of coarse steps 1
OUTLYING = 8.0  # changes by noise from its mean at which the outermost value of an axis is no noise any more
LEAST_END = 0.1  # share of the declared range at which an undeclared end of it may be
NEAREST = 3.0, 0.5  # changes by noise that it comes nearer than to any value without a dead zone; to one it began with
NEAREST_STEPS = 2.0  # and steps


@dataclass(slots=True)
class AxisWatch:
    """One axis.

    Attributes:
        value: the newest [N, Nm].
        held: how long it has been that [s].
        repeats: so many readings have repeated it.
        stuck: whether that is a fault; for `SensorWatch` to say.
    """

    value: float = math.nan
    held: float = 0.0
    repeats: int = 0
    weight: float = 0.0  # identified weight when the value came
    readings: float = 0.0
    changes: float = 0.0
    turns: float = 0.0
    step: float = 0.0  # the last change
    scale: float = 0.0
    mean: float = 0.0
    low: float = math.inf
    high: float = -math.inf
    rest: float = math.nan  # a value it repeated
    trusted: bool = False  # it stayed there before its noise was known, and left by itself
    lived: bool = False  # its noise was known once
    gap: float = math.inf  # to the nearest other value it took since
    returned: bool = False  # to that value, since then
    visits: float = 0.0  # readings that were that value, and of those
    stays: float = 0.0  # such that repeated the one before
    grid: float = math.inf  # largest step of which all changes were multiples; next to nothing if there is none
    stuck: bool = False

    def take(self, value: float, weight: float, dt: float) -> None:
        """A reading, and the identified weight in it."""
        change = value - self.value
        if abs(change) <= RESOLUTION:
            self.held += dt
            self.repeats += 1
            if math.isnan(self.weight):
                self.weight = weight
            return
        if math.isfinite(change):
            self._left(value, change)
        self.value, self.weight, self.held, self.repeats = value, weight, 0.0, 0
        self.low, self.high = min(self.low, value), max(self.high, value)

    def _left(self, value: float, change: float) -> None:
        """Another value: what the last one's stay says."""
        if self.repeats:
            self._remember()
        if self.value == self.rest and not self.stuck:
            self.visits, self.stays = self.visits + 1 + self.repeats, self.stays + self.repeats
        # A rest says nothing of how often it repeats values elsewhere, nor is what comes after it a turn of the noise.
        idle = self.stuck or self.resting() or (self.trusted and self.value == self.rest and self.gap == math.inf)
        if self.readings >= REMEMBERED:
            self.readings, self.changes, self.turns = self.readings / 2, self.changes / 2, self.turns / 2
        self.readings += 1 if idle else 1 + self.repeats
        self.changes += 1
        size = abs(change)
        if change * self.step < 0.0 and not idle:
            self.turns += 1
            smaller = PER_SMALLER * min(size, abs(self.step))
            self.scale += max(0.02, 1.0 / self.turns) * (smaller - self.scale)
        self.step = change
        self.mean += max(0.02, 1.0 / self.changes) * (value - self.mean)
        if value != self.rest:
            self.gap = min(self.gap, abs(value - self.rest))  # NaN compares false
        else:
            self.returned = True
        # Euclid's algorithm: what is left of a change beside whole steps holds whole steps too.
        left = size if self.grid == math.inf else abs(size - self.grid * round(size / self.grid))
        self.grid = left if left > RESOLUTION else self.grid
        self.lived = self.lived or self.noisy(0.0)

    def _remember(self) -> None:
        """The value that it leaves may be that of a dead zone, if no other is."""
        trusted = self.repeats >= RESTED and not self.lived
        if self.value == self.rest:
            self.trusted |= trusted
        elif trusted or not (self.apart() and (self.trusted or self.returned)):
            self.rest, self.trusted, self.gap, self.returned = self.value, trusted, math.inf, False
            self.visits = self.stays = 0.0

    def noisy(self, step: float) -> bool:
        """Whether it is known to have noise that would change the next readings, in steps of ``step`` at least."""
        return (
            self.readings >= FEWEST_READINGS
            and self.turns >= LEAST_TURNS * self.changes
            and self.changes >= LEAST_CHANGES * self.readings
            and self.scale >= LEAST_SPREAD * max(step, self.grid)
        )

    def needed(self, here: bool = False) -> float:
        """So many repeats are no chance any more; ``here``, at the value that it has, if that is one it comes back to.

        Noise about as wide as a dead zone repeats the zone's value more often than any other.
        """
        repeated = self.readings - self.changes
        chance = (repeated + 2.0 * math.sqrt(repeated) + 1.0) / self.readings if repeated >= 1.0 else 0.0
        if self.changes:
            mean = (self.scale or abs(self.step)) * self.changes / self.readings  # over repeats too
            chance = max(chance, math.erf(self.grid / (math.sqrt(2.0 * math.pi) * mean)))
        if here and self.value == self.rest and self.visits >= FEWEST_READINGS:
            chance = max(chance, (self.stays + 2.0 * math.sqrt(self.stays) + 1.0) / self.visits)
        if chance >= 1.0:
            return math.inf
        return max(FEWEST_REPEATS, math.log(CHANCE) / math.log(chance)) if chance > 0.0 else FEWEST_REPEATS

    def heavy(self, weight: float, least: float, step: float, known: bool) -> bool:
        """Whether the weight has changed along with the attitude, and the reading has not."""
        if not self.changes and (not known or self.repeats < FEWEST_READINGS):
            return False
        smooth = self.readings >= FEWEST_READINGS and self.turns < LEAST_TURNS * self.changes
        if self.changes and not smooth and self.repeats < self.needed():
            return False  # noise may have hidden the change by chance
        grid = self.grid if self.changes >= FEWEST_READINGS / 2 else 0.0
        return abs(weight - self.weight) > least + 2.0 * max(step, grid, self.gap if self.resting() else 0.0)

    def apart(self) -> bool:
        """Whether it has never been near the value it rested at, but exactly there."""
        return self.gap > max(NEAREST[self.trusted] * self.scale, NEAREST_STEPS * self.grid)

    def zone(self) -> float:
        """Half the width [N, Nm] at most of the dead zone that it has shown, 0 if none."""
        return self.gap if self.returned and self.scale and self.apart() else 0.0

    def resting(self) -> bool:
        """Whether the value is that of a dead zone in which it rested before its noise was known."""
        return self.trusted and self.value == self.rest and self.zone() > 0.0

    def outermost(self, limit: float) -> bool:
        """Whether it came to a value farther out than noise and than any other, as the end of a range is.

        In one leap a fault comes to any value: then it has to be a share of the declared ``limit`` at least.
        """
        far, out = abs(self.value - self.mean), abs(self.value)
        if self.readings < FEWEST_READINGS or far <= OUTLYING * self.scale or out <= abs(self.mean):
            return False
        if far <= 2.0 * abs(self.step) and out < LEAST_END * limit:
            return False
        return self.value >= self.high if self.value > 0.0 else self.value <= self.low
