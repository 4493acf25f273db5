"""A stack that runs already, made ready for a run: the scene set back, parameters as the run wants them."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

from services.experiment.play.course import Run
from services.experiment.spec import Experiment
from shared import topics
from shared.parameters import Refused
from shared.topics import Query
from shared.wire.bus import NoReply
from shared.wire.client import Client

ROBOT_WITHIN = 30.0  # [s] for the robot process to answer
TASK_WITHIN = 5.0  # [s] for the task to see that the gripper is empty
AGAIN = 0.2  # [s] between two attempts


def set_back(client: Client, within: float = 0.0, pause: Callable[[float], None] = time.sleep) -> None:
    """Sets the simulated scene back for another carry, and the task, if there is one, to its beginning.

    Args:
        client: on the stack's bus.
        within: time [s] to wait for a robot process to answer.
        pause: lets a time [s] pass.

    Raises:
        NoReply: no simulated robot is there, or the task does not answer.
        Refused: the task does not begin anew; with its reason.
    """
    tasked = topics.TASK_COMMAND.server in client.bus.living()
    if tasked:
        # First: nobody commands a robot that is about to be somewhere else.
        client.ask(topics.TASK_COMMAND, {"command": "abort"})
    _ask_until(client, topics.SIM_COMMAND, {"command": "reset"}, within, NoReply, pause)
    if tasked:
        # It has to hear of the empty gripper first, and of the robot's new session.
        _ask_until(client, topics.TASK_COMMAND, {"command": "reset"}, TASK_WITHIN, Refused, pause)


def _ask_until(
    client: Client,
    query: Query,
    request: dict[str, Any],
    within: float,
    passing: type[Exception],
    pause: Callable[[float], None],
) -> None:
    """Asks again after a failure that may pass, for a time [s]."""
    for _ in range(round(within / AGAIN)):
        with suppress(passing):
            client.ask(query, request)
            return
        pause(AGAIN)
    client.ask(query, request)


def playable(experiment: Experiment, name: str = "") -> Run:
    """The run of a name, the filmed one without a name, if it can be played on a stack that was not started for it.

    Raises:
        ValueError: there is no such run, or it differs from the filmed one in what a running process does not change.
    """
    usual = experiment.run_named(experiment.filmed)
    run = experiment.run_named(name) if name else usual
    if (_fixed(run), run.further) == (_fixed(usual), usual.further):
        return run
    others = [one.name for one in experiment.known if (_fixed(one), one.further) == (_fixed(usual), usual.further)]
    raise ValueError(
        f"run {name!r} needs a stack of its own: tandem run {experiment.name} --runs {name}; "
        f"on a running one: {', '.join(others)}"
    )


def _fixed(run: Run) -> dict[str, Any]:
    """What the processes take at their start only."""
    changeable = {query.server for query in topics.PARAMETER_QUERIES}
    return {service: values for service, values in run.settings.items() if service not in changeable}


@contextmanager
def as_wanted(client: Client, run: Run) -> Iterator[None]:
    """Whoever takes parameters while it runs has those of the run meanwhile, and afterwards what it had before.

    Raises:
        NoReply: one of them does not answer.
        Refused: one of them does not take a parameter.
    """
    before: dict[Query, dict[str, Any]] = {}
    try:
        for query in topics.PARAMETER_QUERIES:
            if wanted := run.settings.get(query.server):
                table = client.ask(query)["parameters"]
                before[query] = {name: table[name]["value"] for name in wanted}
                client.ask(query, {"set": wanted})
        yield
    finally:
        for query, values in before.items():
            with suppress(NoReply, Refused):
                client.ask(query, {"set": values})
