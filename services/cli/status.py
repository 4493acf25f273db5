"""`tandem status`: every service alive or lost, what is wrong and what to do about it."""

from __future__ import annotations

import time

import typer
from rich.console import Console
from rich.text import Text

from services.cli.common import DEFAULT_ENDPOINT, DEFAULT_ROBOT, AsJson, Connect, Robot, open_bus
from services.cli.health import diagnose
from services.cli.health.diagnose import Row, control_line, robot_line, task_line
from services.cli.health.view import details, document, services_table, summary
from services.cli.health.watch import Watch
from services.cli.listing import say, show_json
from services.cli.stack.plan import remembered
from shared import topics
from shared.messages import ExternalWrench
from shared.processes import STACK

LISTEN = 1.2  # [s]: two health periods and a bit; less when everybody has spoken


def status(as_json: AsJson = False, robot: Robot = DEFAULT_ROBOT, connect: Connect = DEFAULT_ENDPOINT) -> None:
    """Show every service once; exit status 1 if something is wrong."""
    known = remembered(robot, connect)
    console = Console()
    with open_bus(robot, connect) as bus:
        watch = Watch(bus)
        expected = STACK if known is None else known.expected
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
        wrong = _wrong(rows, watch)
        if as_json:
            show_json({"robot": robot, "endpoint": connect, **document(rows, watch, wrong)})
        else:
            say(console, Text(f"robot {robot} on {connect}", style="bold"))
            console.print(services_table(rows, {}))
            for line in (*details([row for row in rows if row.ok]), *summary(watch)):
                say(console, line)
            console.print()
            for reason in wrong:
                say(console, Text(f"wrong: {reason}", style="red"))
            if not wrong:
                say(console, _fine(watch.message(topics.WRENCH_EXTERNAL)))
    if wrong:
        raise typer.Exit(1)


def _wrong(rows: list[Row], watch: Watch) -> list[str]:
    """What is wrong, and what to do about it."""
    task = watch.message(topics.TASK_STATUS)
    wrong = [f"{row.service} is {row.state}: {row.detail}" for row in rows if not row.ok]
    # What a service has said of a topic already is not said twice.
    wrong += [text for key, text in watch.trouble().items() if not any(key in told for told in wrong)]
    if not wrong:
        states = (robot_line(watch.message(topics.STATE_ROBOT)), control_line(watch.message(topics.CONTROL_STATUS)))
        wrong += [text for text, ok in (*states, *([task_line(task)] if task else [])) if not ok]
    return wrong


def _fine(wrench: ExternalWrench | None) -> Text:
    if wrench is not None and wrench.zero_age is not None and wrench.zero_age < 0.0:
        bound = max(wrench.error_bound[:3])
        return Text(f"everything works, but the sensor has no zero of this run (+-{bound:.1f} N): `tandem tare`")
    return Text("everything works", style="green")
