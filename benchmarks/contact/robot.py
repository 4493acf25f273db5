"""The robot of the contact simulation: a velocity source with delay, gate and first-order lag.

A command reaches the gate after its delay, acts until the next one arrives or its `ttl` has passed (then it is zeroed,
as the gate in front of every robot does), and goes through a first-order lag. The twist is integrated on SE(3) in
closed form over each sub-step, so the path depends on the sub-steps' length in nothing but the order of its rotations.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from shared.spatial import Array


@dataclass(frozen=True)
class Path:
    """A stretch of the tool's motion: times (n,) [s], positions (n, 3) [m], rotations (n, 3, 3)."""

    times: Array
    positions: Array
    rotations: Array


class Robot:
    """The tool's pose under twist commands.

    Attributes:
        position: (3,) [m].
        rotation: (3, 3) tool to base.
        twist: (6,) the twist now, after the lag [m/s, rad/s].
        travelled: path lengths (translation [m], rotation [rad]).
    """

    def __init__(self, position: Array, rotation: Array, lag: float) -> None:
        """Starts at rest; ``lag`` is the time constant [s], 0 for none."""
        self.position = position
        self.rotation = rotation
        self.twist = np.zeros(6)
        self.travelled = np.zeros(2)
        self._lag = lag
        self._acting = np.zeros(6)
        self._expires = -math.inf
        self._coming: deque[tuple[float, Array, float]] = deque()

    @property
    def fastest(self) -> Array:
        """Upper bounds (2,) [m/s, rad/s] of the speeds until the next command is given."""
        candidates = [self.twist, self._acting, *(twist for _, twist, _ in self._coming)]
        return np.linalg.norm(np.array(candidates).reshape(-1, 2, 3), axis=2).max(axis=0)

    def command(self, arrival: float, twist: Array, ttl: float) -> None:
        """A twist (6,) that reaches the gate at time ``arrival`` [s] and is good for ``ttl`` [s] from then."""
        if self._coming and arrival < self._coming[-1][0]:
            arrival = self._coming[-1][0]  # one publisher's samples never overtake each other
        self._coming.append((arrival, twist, ttl))

    def advance(self, start: float, end: float, step: float) -> Path:
        """The motion from ``start`` to ``end`` [s] in sub-steps of at most ``step`` [s]."""
        lengths: list[float] = []
        means: list[Array] = []
        now = start
        while now < end - 1e-12:
            until = self._segment(now, end)
            count = max(1, math.ceil((until - now) / step - 1e-9))
            means.append(self._through_lag((until - now) / count, count))
            lengths += [(until - now) / count] * count
            now = until
        return self._integrate(start, np.array(lengths), np.concatenate(means))

    def _segment(self, now: float, end: float) -> float:
        """Takes what has arrived by ``now`` and says until when the acting command stays the same."""
        while self._coming and self._coming[0][0] <= now + 1e-12:
            arrival, self._acting, ttl = self._coming.popleft()
            self._expires = arrival + ttl
        if now >= self._expires - 1e-12:
            self._acting = np.zeros(6)
            self._expires = math.inf
        following = self._coming[0][0] if self._coming else math.inf
        return min(end, following, self._expires)

    def _through_lag(self, step: float, count: int) -> Array:
        """Mean twists (count, 6) over equal sub-steps of a constant command, behind the lag."""
        if self._lag <= 0.0:
            self.twist = self._acting
            return np.broadcast_to(self._acting, (count, 6))
        edges = np.exp(-step / self._lag * np.arange(count + 1))
        away = self.twist - self._acting
        self.twist = self._acting + away * edges[-1]
        return self._acting + (edges[:-1] - edges[1:])[:, None] * (self._lag / step) * away

    def _integrate(self, start: float, lengths: Array, twists: Array) -> Path:
        moves = twists * lengths[:, None]
        positions = self.position + np.cumsum(moves[:, :3], axis=0)
        turns = _rotations(moves[:, 3:])
        reach = 1
        while reach < len(turns):  # running product by doubling: later turns multiply from the left
            turns[reach:] = turns[reach:] @ turns[:-reach]
            reach *= 2
        rotations = turns @ self.rotation
        self.position, self.rotation = positions[-1], rotations[-1]
        self.travelled += np.linalg.norm(moves.reshape(-1, 2, 3), axis=2).sum(axis=0)
        return Path(start + np.cumsum(lengths), positions, rotations)


def _rotations(vectors: Array) -> Array:
    """Rotation matrices (n, 3, 3) of rotation vectors (n, 3) [rad] below half a turn (Rodrigues)."""
    square = np.einsum("ni,ni->n", vectors, vectors)
    if square.max() < 1e-3:  # what is left out of the series is below rounding
        sine = 1.0 - square * (1.0 - square / 20.0) / 6.0
        versine = 0.5 - square * (1.0 - square / 30.0) / 24.0
    else:
        angles = np.sqrt(square)
        sine = np.sinc(angles / math.pi)
        versine = np.sinc(angles / (2.0 * math.pi)) ** 2 / 2.0
    cross = np.zeros((len(vectors), 3, 3))
    cross[:, 2, 1], cross[:, 0, 2], cross[:, 1, 0] = vectors.T
    cross[:, 1, 2], cross[:, 2, 0], cross[:, 0, 1] = -vectors.T
    return np.eye(3) + sine[:, None, None] * cross + versine[:, None, None] * (cross @ cross)
