"""Whether the robot's gate has the last word: what is stale, wrong, too much or a stranger's is not carried out.

Every command here is one that would move the tool by millimetres at most if the gate let it through.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import msgpack
import numpy as np

from services.cli.check.bench import Bench
from services.cli.check.heard import Commander
from services.cli.check.moving import PATIENCE, RESTS_WITHIN, SPEED, TTL, along_z, swaying
from services.cli.check.rows import Row, judged
from shared.messages import LONGEST_TTL, TwistCommand
from shared.robot.side import at_present
from shared.topics import COMMAND_EE_TWIST, STATE_EE

MOVED = 0.001  # [m] of a tool that moves although it must not
BRIEF = 0.03  # [s] ttl of a command over the limit
NAMED_WITHIN = 3.0  # [s] in state/robot, what is refused
STOPS_WITHIN = 0.5  # [s] after a stop was engaged; the message's way included
REPEAT = 0.05  # [s] between two messages of a stop, until state/robot shows it
_HEADER = {"seq": 1, "session": 1, "stamp": 1, "valid": True}
_TWIST = {"linear": [0.0, 0.0, -SPEED], "angular": [0.0] * 3, "ttl": 0.1}
GARBAGE = {
    "nothing at all": b"",
    "bytes that are no MessagePack": b"\xc1" * 50,
    "a megabyte": bytes(1_000_000),
    "no header": msgpack.packb(_TWIST),
    "NaN": msgpack.packb(_HEADER | _TWIST | {"linear": [math.nan, 0.0, 0.0]}),
    "infinity": msgpack.packb(_HEADER | _TWIST | {"angular": [0.0, math.inf, 0.0]}),
    "two numbers for three": msgpack.packb(_HEADER | _TWIST | {"linear": [0.0, -SPEED]}),
    "text for a number": msgpack.packb(_HEADER | _TWIST | {"ttl": "long"}),
    "a field missing": msgpack.packb(_HEADER | {"angular": [0.0] * 3, "ttl": 0.1}),
}
"""Payloads that are no command, by what they are."""


class Gates:
    """Tries what the gate of the tool has to refuse.

    Args:
        bench: with the robot.
        first, second: two who command it.
    """

    def __init__(self, bench: Bench, first: Commander, second: Commander) -> None:
        self._bench, self._robot, self._first, self._second = bench, bench.robot, first, second

    def rows(self) -> Iterator[Row]:
        """A row for each rule."""
        rules: tuple[tuple[str, Callable[[], str], str], ...] = (
            ("silence", self._silence, "the tool rests when commands cease"),
            ("ttl", self._ttl, f"one command acts for {LONGEST_TTL:g} s at most, whatever its ttl"),
            ("invalid", self._invalid, "a command marked invalid moves nothing"),
            ("sequence", self._sequence, "a command of long ago moves nothing, and is named"),
            ("second", self._second_session, "of two who command the second moves nothing, and is named"),
            ("clamping", self._excess, "an excess is clamped, and named"),
            ("garbage", self._garbage, f"{len(GARBAGE)} kinds move nothing, and are named"),
            ("stop", self._stop, "latched, whoever commands, until a valid release"),
        )
        for what, rule, right in rules:
            if not self._bench.within(RESTS_WITHIN, self._robot.at_rest):
                yield Row(what, False, "not tried: the tool does not rest")
                continue
            wrong = rule()
            # Whatever has gone wrong, the next one begins at rest.
            self._second.make, self._first.make = lambda: None, lambda: along_z(0.0)
            self._bench.wait(LONGEST_TTL)
            self._first.make = lambda: None
            yield judged(what, wrong, right)

    def _moving(self) -> bool:
        return abs(float(self._robot.tool.linear[2])) > 0.4 * SPEED

    def _still_from(self) -> Callable[[], bool]:
        start = self._robot.tool.position
        return lambda: float(np.linalg.norm(self._robot.tool.position - start)) < MOVED

    def _starts(self) -> str:
        """Have it move; why it does not, or ""."""
        self._first.make = swaying()
        if self._bench.within(PATIENCE, self._moving):
            return ""
        return f"the tool does not follow commands; state/robot says: {self._robot.status.reason or 'nothing'}"

    def _silence(self) -> str:
        if wrong := self._starts():
            return wrong
        self._first.make = lambda: None
        if not self._bench.within(RESTS_WITHIN, self._robot.at_rest):
            return f"the tool still moves {RESTS_WITHIN:g} s after the last command, of a ttl of {TTL:g} s"
        if not self._bench.within(RESTS_WITHIN, lambda: self._robot.status.mode == "holding"):
            return f'it rests, and state/robot says "{self._robot.status.mode}" instead of "holding"'
        return ""

    def _ttl(self) -> str:
        start, allowed = self._robot.tool.position, SPEED * LONGEST_TTL * 1.1 + MOVED
        command = along_z(-SPEED, 100.0)
        self._first.put(COMMAND_EE_TWIST.key, self._first.payload(command))
        if not self._bench.throughout(1.5, lambda: float(np.linalg.norm(self._robot.tool.position - start)) < allowed):
            return f"one command of ttl 100 s moved the tool by more than {1e3 * allowed:.1f} mm: it acts for too long"
        return ""

    def _invalid(self) -> str:
        still, command = self._still_from(), along_z(-SPEED)
        self._first.make = lambda: self._first.payload(command, valid=False)
        return "" if self._bench.throughout(0.5, still) else "commands whose header says valid: false move the tool"

    def _sequence(self) -> str:
        still, turn = self._still_from(), iter(range(10**9))
        self._first.number += 1000
        old = self._first.number - 900

        def make() -> TwistCommand | bytes:
            if next(turn) % 2 == 0:
                return along_z(0.0)
            return self._first.payload(along_z(-SPEED), number=old)

        named = self._named("sequence", "order", "seq")
        self._first.put(COMMAND_EE_TWIST.key, self._first.payload(along_z(0.0)))
        self._first.make = make
        if not self._bench.throughout(0.5, still):
            return "commands with an older seq than one before them move the tool"
        return named("commands out of sequence")

    def _second_session(self) -> str:
        still, named = self._still_from(), self._named("second", "another", "session")
        self._first.make = lambda: along_z(0.0)
        self._bench.throughout(0.3, still)
        self._second.make = lambda: along_z(-SPEED)
        if not self._bench.throughout(0.5, still):
            return "a second session moves the tool while the first one commands it to stand still"
        return named("a second session that commands the tool")

    def _excess(self) -> str:
        limit = self._robot.status.max_linear
        named, sign = self._named("clamp", "limit", "excess"), iter(range(10**9))
        seen = self._robot.all(STATE_EE)[-1].header.seq
        # To and fro, two commands each way but for the first: it hardly gets away, clamped or not.
        self._first.make = lambda: along_z(1.2 * limit * (1 if (next(sign) + 1) // 2 % 2 == 0 else -1), BRIEF)
        said = named("commands over the limit")
        self._first.make = lambda: along_z(0.0)
        self._bench.within(RESTS_WITHIN, self._robot.at_rest)
        speeds = [np.linalg.norm(one.message.linear) for one in self._robot.all(STATE_EE) if one.header.seq > seen]  # type: ignore[attr-defined]
        if max(speeds) > 1.1 * limit:
            return f"the tool went at {max(speeds):.2f} m/s, its max_linear is {limit:g}: an excess is not clamped"
        return said

    def _garbage(self) -> str:
        for what, payload in GARBAGE.items():
            still, named = self._still_from(), self._named("reject", "garbage", "invalid", "unreadable", "decode")
            self._first.make = lambda payload=payload: payload  # type: ignore[misc]
            if wrong := named(f"payloads that are no command ({what})"):
                return wrong
            if not self._bench.throughout(0.2, still):
                return f"payloads that are no command move the tool ({what})"
        return ""

    def _stop(self) -> str:
        robot = self._robot
        if robot.status.mode == "stopped":
            return f"it is stopped already ({at_present(robot.status.reason)}); release it first: tandem resume"
        if wrong := self._starts():
            return wrong
        try:
            engaged = self._bench.within(RESTS_WITHIN, lambda: self._say(True) and robot.status.mode == "stopped")
            if not engaged:
                return f'state/robot says "{robot.status.mode}" instead of "stopped"'
            if not self._bench.within(STOPS_WITHIN, robot.at_rest):
                return f"the tool still moves {STOPS_WITHIN:g} s after state/robot said that it is stopped"
            still = self._still_from()
            if not self._bench.throughout(0.5, still):
                return "commands move the tool while a stop is engaged"
            if not self._bench.throughout(0.3, lambda: self._say(False, valid=False) and still()):
                return "a release whose header says valid: false releases the stop"
        finally:
            self._first.make = lambda: None
            released = self._bench.within(RESTS_WITHIN, lambda: self._say(False) and robot.status.mode != "stopped")
        return self._starts() if released else "a valid release does not release the stop"

    def _say(self, engaged: bool, valid: bool = True) -> bool:
        """Say a stop once more, which is told from being heard by ``state/robot``; true."""
        self._second.stop(engaged, "check-robot tries the stop", valid)
        self._bench.wait(REPEAT)
        return True

    def _named(self, *words: str) -> Callable[[str], str]:
        """Waits until state/robot names what is going on; what is wrong if it does not, or ""."""
        before = self._robot.status.reason

        def wait(what: str) -> str:
            def told() -> bool:
                reason = self._robot.status.reason
                return reason != before and any(word in reason for word in words)

            if self._bench.within(NAMED_WITHIN, told):
                return ""
            return f"{what} are not named in state/robot, which says: {self._robot.status.reason or 'nothing'}"

        return wait
