"""`tandem top`: what the processes of a robot use, how fast they go, and how late they are."""

from __future__ import annotations

import time
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.live import Live

from services.cli.common import DEFAULT_ENDPOINT, DEFAULT_ROBOT, AsJson, Connect, Robot, open_bus, refuse
from services.cli.health.diagnose import HEALTH_LATE, Heard
from services.cli.health.usage import Usage, UsageMeter
from services.cli.health.watch import Watch
from services.cli.listing import Listing, show_json
from shared.processes import PROCESSES

PERIOD = 1.0  # [s] between two looks, over which CPU is averaged


def top(
    once: Annotated[bool, typer.Option("--once", help="Show it once, over a second, and end.")] = False,
    as_json: AsJson = False,
    robot: Robot = DEFAULT_ROBOT,
    connect: Connect = DEFAULT_ENDPOINT,
) -> None:
    """CPU, memory, rate and late steps of each process of a robot, until Ctrl-C; --json shows it once."""
    with open_bus(robot, connect) as bus:
        watch, meter = Watch(bus), UsageMeter(robot, connect)
        meter.look()
        time.sleep(PERIOD)
        rows = looked(watch, meter)
        if not rows:
            refuse(f"no process of robot {robot} on {connect}: start one with tandem up, or name another --robot", 1)
        if as_json:
            show_json({"robot": robot, "endpoint": connect, "processes": rows})
        elif once or not Console().is_terminal:
            Console().print(shown(rows))
        else:
            _go_on(watch, meter, rows)


def _go_on(watch: Watch, meter: UsageMeter, rows: list[dict[str, Any]]) -> None:
    try:
        with Live(shown(rows), auto_refresh=False) as live:
            while True:
                time.sleep(PERIOD)
                live.update(shown(looked(watch, meter)), refresh=True)
    except KeyboardInterrupt:
        return


def looked(watch: Watch, meter: UsageMeter) -> list[dict[str, Any]]:
    """A row per process that lives, was heard, or runs on this machine."""
    used, heard = meter.look(), watch.health()
    order = [process.name for process in PROCESSES]
    names = set(used) | set(heard) | watch.living()
    return [row(name, used.get(name), heard.get(name)) for name in sorted(names, key=lambda name: _place(order, name))]


def _place(order: list[str], name: str) -> tuple[int, str]:
    return (order.index(name) if name in order else len(order), name)


def row(name: str, usage: Usage | None, heard: Heard | None) -> dict[str, Any]:
    """What is known of a process; null is what it does not tell, or runs on another machine."""
    health = heard.health if heard else None
    return {
        "process": name,
        "pid": usage.pid if usage else None,
        "cpu_percent": round(usage.cpu, 1) if usage else None,
        "memory_MB": round(usage.memory, 1) if usage else None,
        "state": health.state if health else None,
        "health_age_s": round(heard.age, 2) if heard else None,
        "loop_hz": health.loop_hz if health else None,
        "late_steps": health.overruns if health else None,
        "loop_p50_us": health.loop_p50_us if health else None,
        "loop_p99_us": health.loop_p99_us if health else None,
    }


def shown(rows: list[dict[str, Any]]) -> Listing:
    """The rows for a person; a health that is late has its age in words."""
    listing = Listing(
        "process", "pid>", "CPU [%]>", "memory [MB]>", "state", "health [s]>", "rate [Hz]>", "late steps>", "p50 [µs]>",
        "p99 [µs]>",
    )  # fmt: skip
    for one in rows:
        age, state = one["health_age_s"], one["state"] or ""
        late = age is not None and age > HEALTH_LATE
        listing.add(
            one["process"],
            _number(one["pid"], 0),
            _number(one["cpu_percent"], 0),
            _number(one["memory_MB"], 0),
            "silent" if late else state,
            _number(age, 1),
            _number(one["loop_hz"], 0),
            _number(one["late_steps"], 0),
            _number(one["loop_p50_us"], 0),
            _number(one["loop_p99_us"], 0),
        )
    return listing


def _number(value: float | None, digits: int) -> str:
    return "" if value is None else f"{value:.{digits}f}"
