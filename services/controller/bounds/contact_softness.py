"""How stiff the contact is that the tool is following, learnt from the tool's own motion.

Only for giving way to an environment that has proven to move: there the declared stiffness is what no contact exceeds,
and an answer that is right for it is too slow for a softer one. No row and no cap ever sees this estimate, since the
next contact may be harder (docs/guarantee.md, "A moving environment").
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from numpy.typing import ArrayLike

from shared.spatial import Array

FIRST_SHARE = 0.5
"""Share of the declared stiffness that is assumed before anything was learnt."""
_LEAST_SHARE = 0.1
"""Softer contacts than this are followed as if they were this stiff."""
_WINDOW = 2.5
"""Length of the regression in response times: an answer has to be seen to act."""
_ACTS_AFTER = 0.75
"""Delay of the motion in response times: D is the longest one, and a command acts for a period around it."""
_SAMPLES = 40
"""So many samples the window holds at most; a quicker loop leaves some out."""
_FEWEST = 4
"""Fewer samples tell a drift from nothing else."""
_RISE, _FALL = 0.1, 0.5
"""Time constants in response times: quicker to believe in a stiffer contact than in a softer one."""


class ContactSoftness:
    """Regression of the wrench on the displacement that was commanded, and on time.

    Over the last 2.5 D, ``w(t) = w_0 + c t - K x(t)``: c is what the environment's motion adds, K the stiffness along
    the tool's motion, one number in the scale in which the stiffest declared contact has ``largest``. Where the motion
    is too small to tell it from errors, the estimate falls back to its first value.

    Attributes:
        share: of the declared stiffness, within [0.1, 1].
    """

    def __init__(self) -> None:
        self.share = FIRST_SHARE
        self._shown = FIRST_SHARE
        self._now = 0.0
        self._position = np.zeros(6)
        self._commanded: deque[tuple[float, Array]] = deque([(0.0, self._position)])
        self._samples: deque[tuple[float, Array, Array]] = deque()

    def step(
        self,
        wrench: ArrayLike,
        displacement: Array,
        scale: ArrayLike,
        largest: float,
        hidden: float,
        response_time: float,
        dt: float,
    ) -> float:
        """The share now.

        Args:
            wrench: w (6,) [N, Nm].
            displacement: (6,) [m, rad] commanded since the last step.
            scale: x (6,), in which the stiffness is one number.
            largest: [1] eigenvalue of ``x^-1 K x^-1`` for the stiffest declared contact.
            hidden: [1] change of ``x^-1 w`` that tells nothing.
            response_time: D [s].
            dt: [s] since the last step.
        """
        self._now += dt
        self._position = self._position + displacement
        self._commanded.append((self._now, self._position))
        window = max(_WINDOW * response_time, _FEWEST * dt)
        if not self._samples or self._now - self._samples[-1][0] >= window / _SAMPLES:
            acted = self._acted(self._now - _ACTS_AFTER * response_time)
            self._samples.append((self._now, np.array(wrench), acted))
            while self._samples[0][0] < self._now - window:
                self._samples.popleft()
            shown = self._regression(np.array(scale), largest, hidden)
            self._shown = min(1.0, max(_LEAST_SHARE, shown))
        constant = (_RISE if self._shown > self.share else _FALL) * response_time
        self.share += (self._shown - self.share) * (1.0 - math.exp(-dt / constant))
        return self.share

    def _acted(self, time: float) -> Array:
        """Displacement (6,) [m, rad] that was commanded until ``time`` [s]."""
        commanded = self._commanded
        while len(commanded) > 2 and commanded[1][0] <= time:
            commanded.popleft()
        (start, before), (end, after) = commanded[0], commanded[1]
        part = min(1.0, max(0.0, (time - start) / (end - start))) if end > start else 1.0
        return before + part * (after - before)

    def _regression(self, scale: Array, largest: float, hidden: float) -> float:
        times, wrenches, positions = (np.array(column) for column in zip(*self._samples, strict=True))
        count = len(times)
        if count < _FEWEST:
            return FIRST_SHARE
        # What a constant and a steady drift explain is the environment's.
        times = times - times.mean()
        drift = times / math.sqrt(times.dot(times))
        change, motion = wrenches / scale, positions * (largest * scale)
        change, motion = change - change.mean(axis=0), motion - motion.mean(axis=0)
        change, motion = change - np.outer(drift, drift @ change), motion - np.outer(drift, drift @ motion)
        known = hidden * hidden
        falls, moves = -np.vdot(change, motion) / count, np.vdot(motion, motion) / count
        return float((FIRST_SHARE * known + falls) / (known + moves)) if known + moves > 0.0 else FIRST_SHARE
