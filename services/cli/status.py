"""`tandem status`: every service alive or lost, what is wrong and what to do about it."""

from __future__ import annotations

import time

import typer
from rich.console import Console

from services.cli.common import DEFAULT_ENDPOINT, DEFAULT_ROBOT, Connect, Robot, open_bus
from services.cli.health import diagnose
from services.cli.health.diagnose import control_line, robot_line, task_line
from services.cli.health.view import details, services_table, summary
from services.cli.health.watch import Watch
from services.cli.stack.plan import remembered
from shared import topics
from shared.processes import STACK

LISTEN = 1.2  # [s]: two health periods and a bit; less when everybody has spoken


def status(robot: Robot = DEFAULT_ROBOT, connect: Connect = DEFAULT_ENDPOINT) -> None:
    """Show every service once; exit status 1 if something is wrong."""
    known = remembered(robot, connect)
    console = Console()
    with open_bus(robot, connect) as bus:
        watch = Watch(bus)
        expected = STACK if known is None else known.services
        shown = watch.living().union(expected)
        deadline = time.monotonic() + LISTEN
        while time.monotonic() < deadline and not watch.complete(shown):
            time.sleep(0.05)
        living = watch.living()
        heard = watch.health()
        if known is None:
            expected = diagnose.one_robot(expected, living, watch.message(topics.STATE_ROBOT))
        rows = diagnose.rows(living, heard, expected)
        if known is None:
            rows = [row if row.service in living | set(heard) else diagnose.never_seen(row.service) for row in rows]
        console.print(f"robot {robot} on {connect}", style="bold", highlight=False)
        console.print(services_table(rows, {}))
        for line in details([row for row in rows if row.ok]):
            console.print(line, soft_wrap=True)
        for line in summary(watch):
            console.print(line, soft_wrap=True)
        robot_text, robot_ok = robot_line(watch.message(topics.STATE_ROBOT))
        control_text, control_ok = control_line(watch.message(topics.CONTROL_STATUS))
        task, trouble = watch.message(topics.TASK_STATUS), watch.trouble()
    wrong = [f"{row.service} is {row.state}: {row.detail}" for row in rows if not row.ok]
    # What a service has said of a topic already is not said twice.
    wrong += [text for key, text in trouble.items() if not any(key in told for told in wrong)]
    if not wrong:
        told = [(robot_text, robot_ok), (control_text, control_ok), *([task_line(task)] if task else [])]
        wrong += [text for text, ok in told if not ok]
    console.print()
    if not wrong:
        wrench = watch.message(topics.WRENCH_EXTERNAL)
        if wrench is not None and wrench.zero_age is not None and wrench.zero_age < 0.0:
            bound = max(wrench.error_bound[:3])
            console.print(f"everything works, but the sensor has no zero of this run (+-{bound:.1f} N): `tandem tare`")
        else:
            console.print("everything works", style="green")
        return
    for reason in wrong:
        console.print(f"wrong: {reason}", style="red", highlight=False, soft_wrap=True)
    raise typer.Exit(1)
