"""One sentence that says why the robot does what it does: a pure function of the newest messages and their ages.

What is old is called old, and nothing is said of what has told nothing. Of several causes the most fundamental is the
sentence: who has lost its voice, a stop, a controller that rests, a limit that is reached, the robot's own limits, what
the task waits for. The rest is ``more``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from enum import Enum
from typing import NamedTuple, TypeVar

import numpy as np

from shared import messages as m
from shared import topics
from shared.clock import in_words
from shared.robot.side import at_present
from shared.schema.records import Record
from shared.topics import CONTROL_STATUS, ROBOT, STATE_ROBOT, TASK_STATUS, Topic

M = TypeVar("M", bound=Record)

AXES = ("x force", "y force", "z force", "torque x", "torque y", "torque z")
"""Names of the six axes of a wrench, base axes."""
UNITS = ("N", "N", "N", "Nm", "Nm", "Nm")
ENDED = ("idle", "done")
"""States of the task that want nothing of the robot."""
SEEKING = ("calibrating", "searching")
"""States of the task whose reason says what they wait for, whatever its first word."""
LONGEST = 200
"""Characters of a reason that are shown: others may say a page."""


class Told(NamedTuple):
    """The newest message of a topic and its age [s]."""

    message: Record
    age: float


Known = Mapping[str, Told]
"""By key; a topic of which nothing was heard is absent."""


class Kind(Enum):
    """What a sentence is about, the gravest first."""

    LOST = "lost"
    """Somebody is not heard: what is drawn is old."""
    STOPPED = "stopped"
    """The robot stands still until somebody does something."""
    HELD = "held"
    """A limit holds it back."""
    WAITING = "waiting"
    """It waits for something."""
    FREE = "free"
    """Nothing holds it back."""


class Sentence(NamedTuple):
    """The sentence, its kind, and what else is to be known, each in one line."""

    text: str
    kind: Kind
    more: tuple[str, ...] = ()


def say(known: Known, cut_off: str = "") -> Sentence:
    """Why the robot does what it does.

    Args:
        known: what was heard.
        cut_off: why nothing can be heard at all, such as a lost router; empty if that is not so.
    """
    if cut_off:
        return Sentence(f"{cut_off}: what is shown is old", Kind.LOST)
    if not known:
        return Sentence("nothing is heard of the robot: `tandem up` starts one", Kind.LOST)
    found = list(_findings(known))
    if not found:
        found.append(_nearest(known))
    (kind, text), *others = found
    # What somebody says of itself is often what is said already.
    told = [said for _, said in found]
    remarks = (line for line in _remarks(known) if not any((line.partition(": ")[2] or line) in said for said in told))
    more = dict.fromkeys(_short(line) for line in (*(other for _, other in others), *remarks))
    return Sentence(_short(text), kind, tuple(more))


def _findings(known: Known) -> Iterator[tuple[Kind, str]]:
    """All that keeps the robot from what it should do, the most fundamental first."""
    robot, control = _fresh(known, STATE_ROBOT), _fresh(known, CONTROL_STATUS)
    if robot is None:
        yield Kind.LOST, _silent(known, STATE_ROBOT, "the robot", ROBOT)
    elif robot.mode == "stopped":
        yield Kind.STOPPED, f"stopped: {robot.reason.removeprefix('stop engaged: ')}"
    if control is None:
        yield Kind.LOST, _silent(known, CONTROL_STATUS, "controller", "controller")
    elif control.state in ("waiting", "braking"):
        kind = Kind.STOPPED if control.state == "braking" else Kind.WAITING
        yield kind, _prefixed(control.state, control.reason)
    elif held := _held(control):
        yield Kind.HELD, held
    if robot is not None and robot.mode == "holding":
        yield Kind.STOPPED, f"the robot executes nothing: {robot.reason or 'it does not say why'}"
    elif robot is not None and robot.mode == "ready" and (own := at_present(robot.reason)):
        yield Kind.HELD, f"held back by the robot itself: {own}"
    yield from _task(known)


def _task(known: Known) -> Iterator[tuple[Kind, str]]:
    task = _fresh(known, TASK_STATUS)
    if task is None:
        last = known.get(TASK_STATUS.key)
        if last is not None and last.message.state not in ENDED:  # type: ignore[attr-defined]
            yield Kind.LOST, _silent(known, TASK_STATUS, "task", "task")
    elif task.reason.startswith("waiting"):
        yield Kind.WAITING, task.reason
    elif task.state == "holding":
        yield Kind.WAITING, f"the task holds: {task.reason}"
    elif task.state in SEEKING:
        yield Kind.WAITING, f"the task is {task.state}: {task.reason}"


def _remarks(known: Known) -> Iterator[str]:
    """What else the controller, the task and everybody's health say."""
    control, task = _fresh(known, CONTROL_STATUS), _fresh(known, TASK_STATUS)
    if control is not None and control.reason and control.state in ("tracking", "yielding"):
        yield f"controller: {control.reason}"
    if task is not None and task.reason:
        yield f"task {task.state}: {task.reason}"
    for key, told in known.items():
        if not key.startswith("health/"):
            continue
        name, health = key.removeprefix("health/"), told.message
        assert isinstance(health, m.Health)
        if told.age > topics.health_topic(name).max_age:
            yield f"{name} says nothing since {in_words(told.age)}"
        elif health.state != "ok":
            yield f"{name} is {health.state}: {health.detail}" if health.detail else f"{name} is {health.state}"


def _held(control: m.ControlStatus) -> str:
    """Which limits hold the tool back; empty if none does."""
    axes = [axis for axis in range(6) if control.active[axis]]
    if axes:
        what = " and ".join(used(control, axis) for axis in axes)
        # It bounds the motion before anything is felt: what could still be met on the way counts, too.
        careful = " (as a precaution)" if control.state == "tracking" else ""
        return f"held back by {what}{careful}"
    if control.state == "yielding":
        return f"giving way to {used(control, int(np.argmax(used_share(control))))}"
    return ""


def used_share(control: m.ControlStatus) -> np.ndarray:
    """Share [1] of each limit (6,) that force and error bound use; NaN where there is no limit."""
    if control.limit is None:
        return np.full(6, math.nan)
    limit = np.where(control.limit > 0.0, control.limit, math.nan)
    return (limit - control.margin) / limit


def used(control: m.ControlStatus, axis: int) -> str:
    """Such as "z force: 24.8 of 25 N"; what is used is the force off the nominal one and the bound on its error."""
    if control.limit is None or control.limit[axis] <= 0.0:
        return f"{AXES[axis]}: {control.margin[axis]:.1f} {UNITS[axis]} left"
    used = control.limit[axis] - control.margin[axis]
    return f"{AXES[axis]}: {_number(used)} of {control.limit[axis]:.3g} {UNITS[axis]}"


def _nearest(known: Known) -> tuple[Kind, str]:
    """That nothing holds the tool back, and which limit comes first; or which one is passed all the same."""
    control = _fresh(known, CONTROL_STATUS)
    assert control is not None
    share = used_share(control)
    if np.isnan(share).all():
        return Kind.FREE, "nothing holds it back"
    axis = int(np.nanargmax(share))
    if control.margin[axis] < 0.0:
        return Kind.HELD, f"past a limit, and not held back: {used(control, axis)}"
    left = f"{_number(control.margin[axis])} {UNITS[axis]} left"
    return Kind.FREE, f"nothing holds it back; nearest: {AXES[axis]}, {left}"


def _fresh(known: Known, topic: Topic[M]) -> M | None:
    """The newest message, None if it is too old to be used."""
    told = known.get(topic.key)
    return told.message if told is not None and told.age <= topic.max_age else None  # type: ignore[return-value]


def _silent(known: Known, topic: Topic, who: str, name: str) -> str:
    """That somebody does not speak: since when, or never."""
    told, health = known.get(topic.key), known.get(f"health/{name}")
    if told is not None:
        return f"no answer from {who} for {in_words(told.age)}: what is shown of it is old"
    if health is not None and health.age <= topics.health_topic(name).max_age:
        assert isinstance(health.message, m.Health)
        # That it is well is no reason for its silence.
        if health.message.state != "ok":
            return f"{who} is {health.message.state}: {health.message.detail}"
    return f"no answer from {who}: nothing was heard on {topic.key}"


def _prefixed(word: str, text: str) -> str:
    return text if text.startswith(word) else f"{word}: {text}" if text else word


def _number(value: float) -> str:
    return f"{value:.1f}" if abs(value) >= 1.0 else f"{value:.2g}"


def _short(text: str) -> str:
    line = " ".join(text.split())
    return line if len(line) <= LONGEST else f"{line[: LONGEST - 3]}..."
