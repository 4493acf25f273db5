"""What a person may do from the page: stop and release the robot, tell the task, lead the simulated person's hands."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from shared import topics
from shared.messages import EnableDevice, Stop
from shared.parameters import Refused
from shared.schema.fields import InvalidField
from shared.topics import Query
from shared.wire.bus import NoReply
from shared.wire.client import Client, forbidden, unanswered
from shared.wire.endpoint import BusError
from shared.wire.latch import Latch

REASON = "STOP on the page"
"""Shown to everybody who asks why the robot stands."""
ANSWER_WITHIN = 3.0  # [s]


class Done(NamedTuple):
    """Whether it is done, and in words what became of it."""

    ok: bool
    said: str


class Actions:
    """Each is done in the thread of whoever asks for it; none waits for another.

    Args:
        client: on the robot's bus.
        latch: of the robot's gate.

    Attributes:
        forbidden: by the name of an action, why the certificate does not allow it; empty if it does.
    """

    def __init__(self, client: Client, latch: Latch) -> None:
        self._client, self._latch = client, latch
        self.forbidden = {
            name: forbidden(what, client.credentials)
            for name, what in (
                ("stop", topics.STOP),
                ("enable", topics.OPERATOR_ENABLE),
                ("task", topics.TASK_COMMAND),
                ("hand", topics.SIM_COMMAND),
            )
        }

    @property
    def by_path(self) -> Mapping[str, Callable[[Mapping[str, Any]], Done]]:
        """All of them, by the path that a page asks them under."""
        return {
            "/stop": self.stop,
            "/release": self.release,
            "/enable": self.enable,
            "/task": self.task,
            "/hand": self.hand,
        }

    def stop(self, asked: Mapping[str, Any]) -> Done:
        """Stop the robot: latched by its gate until it is released."""
        problem = self._say(Stop(engaged=True, reason=REASON))
        return Done(not problem, problem or "stopped: the robot shows it")

    def release(self, asked: Mapping[str, Any]) -> Done:
        """Release a stop, and a controller that has latched a failed sensor."""
        problem = self._say(Stop(engaged=False, reason="released on the page"))
        return Done(not problem, problem or "released: the robot may move")

    def enable(self, asked: Mapping[str, Any]) -> Done:
        """Tell the robot once whether the enabling device is ``pressed``: a page says it again while it is."""
        if why := self.forbidden["enable"]:
            return Done(False, why)
        try:
            self._client.publish(topics.OPERATOR_ENABLE, EnableDevice(asked.get("pressed") is True))
        except BusError as problem:
            return Done(False, str(problem))
        return Done(True, "")

    def _say(self, message: Stop) -> str:
        try:
            return self._latch.say(message)
        except BusError as problem:
            return str(problem)

    def task(self, asked: Mapping[str, Any]) -> Done:
        """Tell the task ``command``: start, abort, release or reset."""
        return self._ask(topics.TASK_COMMAND, {"command": asked.get("command")})

    def hand(self, asked: Mapping[str, Any]) -> Done:
        """Lead the hands to ``target`` (3,) [m], in base_footprint as it stood at the start, or have them do a
        ``script``, which is a text as `tandem hand` takes it.
        """
        wanted = {name: asked.get(name) for name in ("target", "script")}
        return self._ask(topics.SIM_COMMAND, {"command": "hand", **wanted})

    def _ask(self, query: Query, request: dict[str, Any]) -> Done:
        try:
            # A client sends what it is given; what is no request need not travel.
            query.request(request)
            reply = self._client.ask(query, request, ANSWER_WITHIN)
        except NoReply:
            return Done(False, unanswered(self._client.bus, query, ANSWER_WITHIN))
        except Refused as problem:
            return Done(False, f"{query.server} refused: {problem}")
        except (BusError, InvalidField) as problem:
            return Done(False, str(problem))
        state = f": the task is {reply['state']}" if "state" in reply else ""
        return Done(True, f"accepted{state}")
