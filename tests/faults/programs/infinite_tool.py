"""A component of the tool's position is infinite."""

import math

from shared.topics import STATE_EE
from tests.faults.programs.robot import altered, play

if __name__ == "__main__":
    play(
        lambda key, payload: (
            (altered(payload, position=[math.inf, 0.0, 0.0]),) if key == STATE_EE.key else (payload,)
        )
    )
