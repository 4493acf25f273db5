"""View of a stack, as `tandem up` and `tandem status` show it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.console import Group, RenderableType
from rich.text import Text

from services.cli.health.diagnose import Row, control_line, robot_line, task_line
from services.cli.health.watch import Watch
from services.cli.listing import Listing
from services.cli.stack.children import Child
from shared import topics
from shared.clock import in_words
from shared.messages import ControlStatus, ExternalWrench
from shared.schema.records import Record
from shared.topics import Topic

SHOWN_RATES: tuple[Topic, ...] = (
    topics.SENSOR_FT,
    topics.WRENCH_EXTERNAL,
    topics.COMMAND_EE_TWIST,
    topics.STATE_EE,
    topics.CONTROL_TARGET,
)


def services_table(rows: list[Row], processes: Mapping[str, Child]) -> Listing:
    """One line per service: process, health, loop."""
    columns = ("service", *(["process"] if processes else []), "state", "loop>", "p50>", "p99>", "overruns>")
    shown = Listing(*columns)
    for row in rows:
        child = processes.get(row.service)
        cells = [Text(row.service, style="bold")]
        if processes:
            cells.append(_process(child))
        health = row.health
        cells.append(Text(row.state, style="green" if row.ok and row.state == "ok" else "yellow" if row.ok else "red"))
        if health is None:
            cells += [Text("")] * 4
        else:
            cells += [
                Text(f"{health.loop_hz:.0f} Hz"),
                Text(f"{health.loop_p50_us:.0f} µs"),
                Text(f"{health.loop_p99_us:.0f} µs"),
                Text(str(health.overruns)),
            ]
        shown.add(*cells)
    return shown


def details(rows: list[Row]) -> list[Text]:
    """Details of services, a line each, below the table where it has the whole width."""
    return [Text(f"{row.service}: {row.detail}", style="" if row.ok else "red") for row in rows if row.detail]


def _process(child: Child | None) -> Text:
    if child is None:
        return Text("not ours", style="dim")
    if child.status is None:
        return Text(f"pid {child.pid}", style="dim")
    return Text(f"ended ({child.status})", style="bold red")


def summary(watch: Watch) -> list[Text]:
    """Robot, controller, the task if there is one, load and rates, a line each."""
    robot, robot_ok = robot_line(watch.message(topics.STATE_ROBOT))
    control, control_ok = control_line(watch.message(topics.CONTROL_STATUS))
    lines = [
        Text.assemble(("robot       ", "bold"), (robot, "" if robot_ok else "red")),
        Text.assemble(("controller  ", "bold"), (control, "" if control_ok else "red")),
    ]
    task = watch.message(topics.TASK_STATUS)
    if task is not None:
        text, task_ok = task_line(task)
        lines.append(Text.assemble(("task        ", "bold"), (text, "" if task_ok else "red")))
    wrench, status = watch.message(topics.WRENCH_EXTERNAL, 0.2), watch.message(topics.CONTROL_STATUS)
    if wrench is not None:
        lines.append(Text.assemble(("load        ", "bold"), _load(wrench, status)))
    rates = ", ".join(f"{topic.key} {watch.rate(topic):.0f}" for topic in SHOWN_RATES)
    lines.append(Text.assemble(("rates [Hz]  ", "bold"), rates))
    return lines


def _load(wrench: ExternalWrench, status: ControlStatus | None) -> str:
    force = " ".join(f"{value:+6.1f}" for value in wrench.force)
    torque = " ".join(f"{value:+6.2f}" for value in wrench.torque)
    text = f"force [{force}] N, torque [{torque}] Nm, {wrench.compensation}{_zero(wrench)}"
    if status is not None and status.state in ("tracking", "yielding"):
        text += f"; least margin {min(status.margin[:3]):.1f} N, {min(status.margin[3:]):.2f} Nm"
    return text


def _zero(wrench: ExternalWrench) -> str:
    """How old the sensor's zero is, and how well that lets the wrench be known."""
    age, bound = wrench.zero_age, wrench.error_bound
    told = "" if age is None else ", no zero of this run" if age < 0.0 else f", zero {in_words(age)} old"
    return f"{told}, bound {bound[:3].max():.1f} N, {bound[3:].max():.2f} Nm"


def document(rows: list[Row], watch: Watch, wrong: list[str]) -> dict[str, Any]:
    """The same for programs; what is not heard, or older than a second, is null."""
    messages = {
        "gate": watch.message(topics.STATE_ROBOT),
        "controller": watch.message(topics.CONTROL_STATUS),
        "task": watch.message(topics.TASK_STATUS),
        "load": watch.message(topics.WRENCH_EXTERNAL),
    }
    return {
        "good": not wrong,
        "wrong": wrong,
        "services": [_service(row) for row in rows],
        **{name: message.to_plain() if message else None for name, message in messages.items()},
        "units": {name: _units(message) for name, message in messages.items() if message},
        "rates_hz": {topic.key: watch.rate(topic) for topic in SHOWN_RATES},
    }


def _service(row: Row) -> dict[str, Any]:
    loop = {name: getattr(row.health, name, None) for name in ("loop_hz", "loop_p50_us", "loop_p99_us", "overruns")}
    return {"service": row.service, "state": row.state, "ok": row.ok, "detail": row.detail, **loop}


def _units(message: Record) -> dict[str, str]:
    return {name: kind.unit for name, kind, _ in message.kinds() if kind.unit}


def stack_view(rows: list[Row], watch: Watch, processes: Mapping[str, Child], head: str) -> RenderableType:
    """Everything that `tandem up` shows."""
    services = services_table(rows, processes)
    return Group(Text(head, style="bold"), Text(""), services, *details(rows), Text(""), *summary(watch))
