"""Diagnosis of a running stack, from liveliness tokens and messages alone: one row per service, with a remedy."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from shared.messages import ControlStatus, Health, RobotStatus, TaskStatus
from shared.processes import FURTHER, PROCESSES, ROBOTS, ROUTER, STACK

HEALTH_LATE = 1.0  # [s]: health comes every 0.5 s; a service that misses two is lost


@dataclass(frozen=True)
class Heard:
    """The last health message of a service and its age [s]."""

    health: Health
    age: float


@dataclass(frozen=True)
class Row:
    """One service: `state` in one word, what to know about it, and whether that is as it should be."""

    service: str
    state: str
    detail: str
    ok: bool
    health: Health | None = None


def rows(living: Collection[str], heard: Mapping[str, Heard], expected: Collection[str]) -> list[Row]:
    """One row per service that is expected, living or was heard."""
    names = [*expected, *sorted((set(living) | set(heard)) - set(expected))]
    return [_row(name, name in living, heard.get(name), name in expected) for name in names]


def one_robot(expected: Collection[str], living: Collection[str], status: RobotStatus | None) -> tuple[str, ...]:
    """The services that are missed if they do not live: whichever robot process runs, no other one.

    Args:
        expected: of the stack.
        living: by their tokens.
        status: the robot's own word; one that holds no token is there as well.
    """
    there = status is not None or not set(living).isdisjoint(ROBOTS)
    return tuple(name for name in expected if not there or name not in ROBOTS or name in living)


def _row(name: str, token: bool, heard: Heard | None, expected: bool) -> Row:
    if heard is not None and heard.age <= HEALTH_LATE and (token or not expected):
        health = heard.health
        if health.state == "ok":
            # The router has no loop to show.
            return Row(name, "ok", health.detail, True, None if name == ROUTER.name else health)
        return Row(name, health.state, health.detail, health.state == "starting", health)
    remedy = f"start it again {start_with(name)}"
    if token and heard is not None:
        # It holds the place of its kind for as long as it lives.
        return Row(
            name, "lost", f"alive but silent for {heard.age:.1f} s (hung?): end its process, then {remedy}", False
        )
    if token:
        return Row(
            name, "silent", f"alive, but no health heard yet; if that lasts, end its process, then {remedy}", False
        )
    return Row(name, "lost", f"its process is gone: {remedy}", False)


def never_seen(name: str) -> Row:
    """A service that this command has no reason to believe was ever started."""
    remedy = f"start it {start_with(name)}"
    if name in ROBOTS:
        remedy += ", or the process of a real robot as its maker says"
    return Row(name, "never seen", f"nothing was heard of it; {remedy}", False)


def start_with(name: str) -> str:
    """How a process is started, as far as this project knows."""
    if name in (*STACK, *FURTHER):
        return f"with: tandem start {name}"
    if name in (process.name for process in PROCESSES):
        return f"with: python -m services.{name}"
    return "the way it was started: it is no process of this project"


def robot_line(status: RobotStatus | None) -> tuple[str, bool]:
    """The robot's gate in one line, and whether it may move."""
    if status is None:
        return "nothing that can be used was heard on state/robot: is the robot process running?", False
    kind = "simulated" if status.simulated else "real"
    line = f"{kind} robot, {status.base_type} base, {status.mode}" + (f": {status.reason}" if status.reason else "")
    if status.mode == "stopped":
        return line if "tandem resume" in line else f"{line}. Release it with: tandem resume", False
    return line, True


def control_line(status: ControlStatus | None) -> tuple[str, bool]:
    """The controller in one line, and whether it does its work."""
    if status is None:
        return "nothing that can be used was heard on control/status: is the controller running?", False
    line = f"law {status.law}, {status.state}" + (f": {status.reason}" if status.reason else "")
    return line, status.state != "braking"


def task_line(status: TaskStatus) -> tuple[str, bool]:
    """The carrying task in one line, and whether it goes on by itself: holding, it waits for a person."""
    return f"{status.state}: {status.reason}", status.state != "holding"
