"""What becomes of a tool that moves when its robot's process is ended, killed or hung, or loses the robot.

A person does that while this watches: whoever checks a robot has no power over its processes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from services.cli.check.bench import Bench
from services.cli.check.heard import Commander
from services.cli.check.moving import PATIENCE, RESTS_WITHIN, SPEED, TTL, swaying
from services.cli.check.rows import Row, judged
from shared.robot.side import at_present
from shared.topics import STATE_EE

ASKED_WITHIN = 180.0  # [s] for the person
SILENT_AFTER = 0.5  # [s] without a pose, after which the process counts as gone
RESTS_BY_ITSELF = 0.25
"""[s] within which the arm has to come to rest when nobody commands its controllers any more."""
SLACK = 0.002  # [m]
ALLOWED = SPEED * (RESTS_BY_ITSELF + TTL) + SLACK
"""[m] that the tool may have gone on."""
LEFT_ALONE = 1.0  # [s] for which nothing may move afterwards
SILENT = "silent"
ASKED = {
    "restarted": "end the robot's process (Ctrl-C or SIGTERM), and start it again",
    "killed": "kill the robot's process (kill -9), and start it again",
    "hung": "hang the robot's process (kill -STOP) for two seconds, and let it go on (kill -CONT)",
    SILENT: "cut the robot off from its process: the network between them, or its driver",
}
"""What the person is asked to do while the tool sways, by the name of the check."""


class Disturbances:
    """Has the tool sway, and a person disturb it.

    Args:
        bench: with the robot.
        commander: that lets it sway.
        say: tells the person what to do.
    """

    def __init__(self, bench: Bench, commander: Commander, say: Callable[[str], None]) -> None:
        self._bench, self._robot, self._commander, self._say = bench, bench.robot, commander, say

    def rows(self, names: Sequence[str]) -> Iterator[Row]:
        """A row for each, in turn."""
        for name in names:
            if self._robot.status.mode == "stopped":
                self._say("It is stopped. Release it: tandem resume")
                self._bench.within(ASKED_WITHIN, lambda: self._robot.status.mode != "stopped")
            self._commander.make = swaying()
            if not self._bench.within(PATIENCE, lambda: not self._robot.at_rest()):
                wrong = f"the tool does not follow commands; state/robot says: {self._robot.status.reason or 'nothing'}"
            else:
                self._say(f"The tool sways. Now {ASKED[name]}.")
                wrong = self._cut_off() if name == SILENT else self._gone()
            self._commander.make = lambda: None
            right = "latched a stop, and nothing resumed" if name == SILENT else "came to rest, and nothing resumed"
            yield judged(name, wrong, right)

    def _gone(self) -> str:
        """The process is away for a while."""
        bench, robot = self._bench, self._robot
        if not bench.within(ASKED_WITHIN, lambda: bench.silence(STATE_EE) > SILENT_AFTER):
            return f"not tried: state/ee never fell silent within {ASKED_WITHIN:g} s"
        before, session = robot.tool.position, robot.all(STATE_EE)[-1].header.session
        self._commander.make = lambda: None
        if not bench.within(ASKED_WITHIN, lambda: bench.silence(STATE_EE) < SILENT_AFTER):
            return f"it did not come back within {ASKED_WITHIN:g} s"
        bench.wait(SILENT_AFTER)
        way = float(np.linalg.norm(robot.tool.position - before))
        # A simulation that is started anew begins where it always does.
        elsewhere = robot.status.simulated and robot.all(STATE_EE)[-1].header.session != session
        if way > ALLOWED and not elsewhere:
            return (
                f"the tool went on by {1e3 * way:.0f} mm, allowed are {1e3 * ALLOWED:.0f} mm: what the robot's own "
                f"controllers were told last has to end at rest within {RESTS_BY_ITSELF:g} s"
            )
        return self._still("after it came back")

    def _cut_off(self) -> str:
        """The process is there, and the robot is not."""
        bench, robot = self._bench, self._robot
        if not bench.within(ASKED_WITHIN, lambda: robot.status.mode == "stopped"):
            return f"not tried, or no stop was latched within {ASKED_WITHIN:g} s: the robot's silence has to latch one"
        why, last = at_present(robot.status.reason), robot.all(STATE_EE)[-1].arrival
        self._say(f"It has stopped ({why}). Now join them again.")
        if not bench.within(ASKED_WITHIN, lambda: robot.all(STATE_EE)[-1].arrival > last):
            return f"state/ee is not heard again within {ASKED_WITHIN:g} s"
        bench.wait(RESTS_BY_ITSELF)
        # Somebody still commands it.
        wrong = self._still("although a stop was latched and nobody released it")
        if not wrong and robot.status.mode != "stopped":
            return "the stop was released by itself"
        if not wrong:
            self._say("Release it: tandem resume")
            released = bench.within(ASKED_WITHIN, lambda: robot.status.mode != "stopped")
            bench.within(RESTS_WITHIN, robot.at_rest)
            return "" if released else "it was not released"
        return wrong

    def _still(self, when: str) -> str:
        start = self._robot.tool.position
        still = self._bench.throughout(
            LEFT_ALONE, lambda: float(np.linalg.norm(self._robot.tool.position - start)) < SLACK
        )
        return "" if still else f"the tool moves {when}"
