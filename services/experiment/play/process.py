"""The player as a process: on the bus, in real time, until the run has ended or a signal comes."""

from __future__ import annotations

import json
import sys
import threading
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from services.experiment.play.course import ANSWER_WITHIN, Ask, Failed
from services.experiment.play.machine import machine
from services.experiment.play.player import Answered, OnHeard, Player
from services.experiment.play.recording import END, RECORDING, RUN
from shared import topics
from shared.clock import Clock, SteadyClock, seconds
from shared.loop.door import SECOND, Door, Occupied
from shared.loop.process import StopRequest, told_waiting
from shared.loop.runner import Runner
from shared.parameters import Refused
from shared.wire.bus import Bus, NoReply
from shared.wire.client import Client
from shared.wire.credentials import Credentials
from shared.wire.endpoint import BusError
from shared.wire.log import LogWriter
from shared.wire.publisher import Publisher
from shared.wire.subscription import Subscription
from shared.wire.zenoh import ZenohBus

UNFINISHED = "unfinished.mcap"
"""Name of a recording whose run has not been played to its end: nothing is judged by it."""
Compose = Callable[[Bus, Clock, Callable[[Ask, Answered], None], OnHeard], Player]
"""Makes a player of a bus, a clock, how to send a request without waiting, and what is given everything heard."""


def play(compose: Compose, robot: str, connect: str, folder: Path, as_json: bool) -> int:
    """Plays a run against the stack of a robot and records it.

    Args:
        compose: makes the run's player.
        robot: first chunk of every key.
        connect: endpoint of the router.
        folder: that the recording goes to.
        as_json: progress for programs.

    Returns:
        Exit status: 0 when done and after a signal; with one line 1 when the run could not be completed, 3 if another
        experiment is played with this robot.

    Raises:
        BusError: the bus cannot be opened.
    """
    stop = StopRequest()
    folder.mkdir(parents=True, exist_ok=True)
    try:
        bus = ZenohBus(
            robot, connect, give_up=told_waiting("experiment", connect, stop), credentials=Credentials.given(robot)
        )
    except BusError:
        if stop.requested:
            return 0
        raise
    try:
        client = Client(bus)
        Door(bus, "experiment", client.publisher.session, f"as {robot} on {connect}").enter(lambda: stop.requested)
        about = {
            "robot": robot,
            "bus": f"Zenoh, router at {connect}",
            "date": time.strftime("%Y-%m-%d %H:%M"),
            **machine(),
        }
        reason = _recorded(compose, client, folder, about, stop, as_json)
    except Occupied as problem:
        print(f"experiment: {problem}", file=sys.stderr, flush=True)
        return SECOND
    finally:
        bus.close()
    if reason:
        print(f"experiment: {folder.name}: {reason}", file=sys.stderr, flush=True)
    return 1 if reason else 0


def _recorded(
    compose: Compose, client: Client, folder: Path, about: dict[str, Any], stop: StopRequest, as_json: bool
) -> str:
    """Plays and records; returns why the run was not completed, empty if it was or had to stop.

    Raises:
        OSError: nothing can be written.
    """
    unfinished = folder / UNFINISHED
    unfinished.unlink(missing_ok=True)
    log = LogWriter(unfinished, about)
    try:
        player = compose(client.bus, client.clock, partial(_ask_aside, client), log.take)
        log.note(RUN, player.about())
        progress = Progress(as_json, client.watch(topics.TASK_STATUS))
        reason = _conduct(player, client.bus, client.publisher, stop, progress)
        log.note(END, player.end())
    finally:
        log.close()
    if log.problem or log.lost:
        return log.problem or f"{log.lost} of {log.heard} messages could not be written in time to {folder}"
    if not reason and not stop.requested:
        unfinished.replace(folder / RECORDING)
    return reason


def _conduct(player: Player, bus: Bus, publisher: Publisher, stop: StopRequest, progress: Progress) -> str:
    """Runs the loop until the end; returns why it failed, empty if it did not."""
    clock = SteadyClock()
    runner = Runner(player, bus, clock, wake=stop.wake.set, publisher=publisher)
    while not (stop.requested or player.finished):
        left = seconds(runner.next_deadline() - clock.now_ns())
        if left > 0:
            stop.wake.wait(left)
        stop.wake.clear()
        try:
            runner.poll()
        except Failed as problem:
            return str(problem)
        progress.show(player)
    return ""


def _ask_aside(client: Client, ask: Ask, answered: Answered) -> None:
    """Asks in a thread of its own, so that targets keep going out while the answer takes its time."""

    def wait() -> None:
        try:
            answered(client.ask(ask.query, ask.request, ask.duration + ANSWER_WITHIN))
        except (BusError, NoReply, Refused) as problem:
            answered({"ok": False, "error": str(problem)})

    threading.Thread(target=wait, name=f"ask {ask.query.key}", daemon=True).start()


class Progress:
    """Says what happens: phase, time on the protocol's clock, events; as text for people or JSON for programs.

    The JSON has the task's reason too, which changes with every centimetre: programs can choose when to show it.

    Args:
        as_json: whether programs read it.
        task: status of the stack's task.
    """

    def __init__(self, as_json: bool, task: Subscription) -> None:
        self._as_json = as_json
        self._task = task
        self._said: object = None

    def show(self, player: Player) -> None:
        """Prints a line when something has changed."""
        course = player.course
        elapsed = course.elapsed(player.now())
        event = course.events[-1] if course.events else None
        said: object
        if self._as_json:
            # Before the protocol's clock starts the task waits for nothing but its start.
            task = None if elapsed is None else self._task.latest
            said = {
                "phase": course.phase,
                "elapsed": None if elapsed is None else round(elapsed, 1),
                "event": event.name if event else "",
                "reason": task.message.reason if task else "",
            }
            line = json.dumps(said)
        else:
            said = (course.phase, event)
            line = f"{elapsed or 0.0:5.1f} s  {course.phase}"
            line += f" ({event.name}{event.detail and f': {event.detail}'})" if event else ""
        if said != self._said:
            print(line, flush=True)
            self._said = said
