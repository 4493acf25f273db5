"""What is seen without saying anything: keys, form, headers, rates, and whether what is told fits together."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterator

import numpy as np

from services.cli.check.bench import Bench
from services.cli.check.heard import ALWAYS, Heard, Robot
from services.cli.check.rows import Row, judged
from shared.robot.side import at_present
from shared.topics import SENSOR_FT, STATE_EE, STATE_GRIPPER, STATE_JOINTS, STATE_ROBOT, Topic

MISSING_AFTER = 1.0
"""[s] of silence after which a key counts as missing."""
LISTENED = 1.5  # [s] for which rates are looked at
LOST = 0.1  # [1] share of messages that may get lost on the way
CLOCK = 0.05  # [1] by which stamps may go faster or slower than the clock here, over ``LISTENED``
WIDEST = 0.5  # [m] that a gripper opens
_RANGES = {SENSOR_FT: (30.0, 1000.0), STATE_JOINTS: (50.0, 1000.0), STATE_EE: (50.0, 1000.0)}


def allowed_rate(topic: Topic) -> tuple[float, float]:
    """Least and greatest rate [Hz] of a topic that the robot publishes."""
    return _RANGES.get(topic, (topic.rate, topic.rate))


def rate(heard: list[Heard]) -> float:
    """Of the publisher [Hz], by its own account: what the network lost counts too."""
    first, last = heard[0].header, heard[-1].header
    return (last.seq - first.seq) / max((last.stamp - first.stamp) * 1e-9, 1e-9)


def missing(bench: Bench) -> Iterator[Row]:
    """A row for each key that has to be there and is silent; returns within ``MISSING_AFTER``."""
    robot = bench.robot
    bench.within(MISSING_AFTER, lambda: all(topic.key in robot.heard for topic in ALWAYS))
    for topic in ALWAYS:
        if topic.key in robot.heard:
            continue
        unread = [text for text in list(robot.rejected) if text.startswith(f"{topic.key}:")]
        least, _ = allowed_rate(topic)
        why = f"cannot be read ({unread[-1].partition(': ')[2]})" if unread else "missing"
        said = (
            f"{why}, listened for {MISSING_AFTER:g} s. Every robot publishes it, {least:g} Hz or more: see contract.md"
        )
        yield Row(topic.key, False, said)


def publications(robot: Robot) -> Iterator[Row]:
    """A row for each key that is heard: form, header and rate, of what came in the last ``LISTENED`` seconds."""
    for topic in ALWAYS:
        heard = robot.all(topic)
        if heard:
            unread = [text for text in list(robot.rejected) if text.startswith(f"{topic.key}:")]
            wrong = unread[-1].partition(": ")[2] if unread else header_fault(heard) or rate_fault(topic, heard)
            yield judged(topic.key, wrong, f"{rate(heard):.3g} Hz" if len(heard) > 1 else "heard")


def header_fault(heard: list[Heard]) -> str:
    """What is wrong with the headers of one key's messages; empty if nothing is."""
    sessions = {one.header.session for one in heard}
    if len(sessions) > 1:
        return f"{len(sessions)} sessions publish it: two of a kind run, or it was started anew; end one"
    if not all(one.header.valid for one in heard):
        return "valid is false: some input of the robot process is not healthy; see state/robot and health"
    pairs = list(itertools.pairwise(one.header for one in heard))
    if any(after.seq <= before.seq for before, after in pairs):
        return "seq does not grow from message to message: count each message of this key by one"
    if any(after.stamp <= before.stamp for before, after in pairs):
        return "stamp does not grow: it is the publisher's steady clock in ns"
    steps = Counter(after.seq - before.seq for before, after in pairs)
    if steps and sum(size * count for size, count in steps.items()) > len(pairs) / (1.0 - LOST) + 2:
        return f"seq grows by {steps.most_common(1)[0][0]} from message to message: by one, or messages get lost"
    span = (heard[-1].arrival - heard[0].arrival) * 1e-9
    told = (heard[-1].header.stamp - heard[0].header.stamp) * 1e-9
    if span > 0.5 * LISTENED and abs(told - span) > CLOCK * span + 0.1:
        return f"stamp went on by {told:.2f} s in {span:.2f} s: it is the publisher's steady clock in ns"
    return ""


def rate_fault(topic: Topic, heard: list[Heard]) -> str:
    """Whether the rate of a key is out of range, in words."""
    least, greatest = allowed_rate(topic)
    if len(heard) < 3:
        return f"{len(heard)} messages in {LISTENED:g} s, wanted {least:g} Hz or more"
    found = rate(heard)
    # What is told on change as well may be told more often.
    most = 1.2 * greatest if topic is not STATE_ROBOT else 20.0
    if 0.8 * least <= found <= most:
        return ""
    return f"{found:.3g} Hz, wanted {least:g} to {greatest:g} Hz"


def contents(robot: Robot) -> Iterator[Row]:
    """Rows about what the messages say, of those keys that are heard."""
    if joints := [one.message for one in robot.all(STATE_JOINTS)]:
        names = {message.name for message in joints}  # type: ignore[attr-defined]
        twice = [name for name, count in Counter(next(iter(names))).items() if count > 1]
        wrong = "name changes from message to message: the same joints in one order" if len(names) > 1 else ""
        wrong = wrong or (f"{', '.join(twice)} stands there twice" if twice else "")
        yield judged("joints", wrong, f"{len(next(iter(names)))} joints in one order")
    if samples := [one.message for one in robot.all(SENSOR_FT)]:
        readings = np.array([(*sample.force, *sample.torque) for sample in samples])  # type: ignore[attr-defined]
        stuck = [axis for axis, way in enumerate(np.ptp(readings, axis=0)) if way == 0.0 and len(readings) > 10]
        offsets = np.array([sample.tool_offset for sample in samples])  # type: ignore[attr-defined]
        wrong = f"axis {', '.join(map(str, stuck))} of 0 to 5 gives one value all the time: stuck" if stuck else ""
        if not wrong and np.ptp(offsets, axis=0).max() > 1e-6:
            wrong = "tool_offset changes: the tool is fixed to the sensor, and the offset in the sensor's axes"
        if not wrong and samples[-1].saturated:  # type: ignore[attr-defined]
            wrong = "saturated: take off what loads it, and look at the sensor's range"
        yield judged("sensor", wrong, "alive, and the tool fixed to it")
    if robot.all(STATE_GRIPPER):
        opening, holds = robot.gripper.opening, "something" if robot.gripper.holding else "nothing"
        wrong = "" if 0.0 <= opening <= WIDEST else f"opening {opening:g} m: between the fingers, 0 to {WIDEST:g} m"
        yield judged("gripper", wrong, f"open by {1e3 * opening:.0f} mm, holds {holds}")
    if robot.all(STATE_ROBOT):
        yield _status(robot)


def _status(robot: Robot) -> Row:
    status = robot.status
    wrong = ""
    if not 0.0 < status.max_linear <= 2.0 or not 0.0 < status.max_angular <= 6.0:
        wrong = (
            f"max_linear {status.max_linear:g} m/s, max_angular {status.max_angular:g} rad/s: "
            "wanted above 0, up to 2 m/s and 6 rad/s"
        )
    elif (status.max_base[1] > 0.0) != (status.base_type == "omni"):
        wrong = f"base_type {status.base_type}, and max_base sideways {status.max_base[1]:g} m/s: they contradict"
    elif status.mode != "ready" and not status.reason:
        wrong = f'mode "{status.mode}" without a reason: say why it does not move'
    why = at_present(status.reason)
    return judged("state", wrong, f"{status.mode}{why and f', {why}'}")
