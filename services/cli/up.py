"""`tandem up` and `tandem start`: a stack, or one service of it, in the foreground."""

from __future__ import annotations

import os
import sys
import tempfile
import threading
import time
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.live import Live

from services.cli.common import (
    DEFAULT_ENDPOINT,
    DEFAULT_ROBOT,
    Connect,
    Links,
    Robot,
    Router,
    open_bus,
    refuse,
    stop_event,
)
from services.cli.extras import need
from services.cli.health import diagnose
from services.cli.health.diagnose import Row
from services.cli.health.view import stack_view
from services.cli.health.watch import Watch
from services.cli.stack.children import Child, Children
from services.cli.stack.page import Page, View
from services.cli.stack.plan import (
    IN_ITS_PLACE,
    STARTABLE,
    Plan,
    check_bridge,
    check_config,
    check_further,
    check_port,
    parse_settings,
    remembered,
    write_config,
)
from services.cli.stack.processes import StackProcesses, wait_for_router
from services.experiment.carry import carry_protocol
from shared.loop.door import SECOND
from shared.processes import FURTHER, process_named
from shared.processes import ROUTER as ROUTER_PROCESS

ROUTER = ROUTER_PROCESS.name
STARTS = (ROUTER, *STARTABLE, *IN_ITS_PLACE)
REFRESH = 0.25  # [s]
ROUTER_WITHIN = 60.0  # [s] for the stack's own router to listen, on a machine that is busy
SPEAKS_WITHIN = 30.0  # [s] for a process to say the first word

Config = Annotated[
    Path | None, typer.Option("--config", envvar="TANDEM_CONFIG", help="TOML file with a table per service.")
]
Set = Annotated[
    list[str], typer.Option("--set", help="SERVICE.NAME=VALUE in TOML, e.g. 'controller.law=\"paper\"'; repeatable.")
]
With = Annotated[list[str], typer.Option("--with", help=f"A further service: {', '.join(FURTHER)}; repeatable.")]


def up(
    robot: Robot = DEFAULT_ROBOT,
    router: Router = DEFAULT_ENDPOINT,
    config: Config = None,
    settings: Set = [],  # noqa: B006 - typer copies it
    further: With = [],  # noqa: B006
    links: Links = None,
    bridge: Annotated[
        str, typer.Option(help=f"A real robot in place of the simulated one, by {', '.join(IN_ITS_PLACE)}.")
    ] = "",
    carry: Annotated[
        bool, typer.Option("--carry", help="With panel, camera and person, base and task, set up for a carry.")
    ] = False,
    view: View = True,
) -> None:
    """Start a stack (router, robot, wrench, controller) and show its state until Ctrl-C."""
    if carry and bridge:
        refuse("--carry and --bridge: choose one; a real robot has its own panel: --with base --with task")
    if carry and config is not None:
        refuse(f"--carry and --config {config}: choose one; --set goes with both")
    parsed, more, config = parse_settings(settings), check_further(further), check_config(config)
    robot_process = check_bridge(bridge)
    need((*Plan(robot, router, robot_process=robot_process).services, *(FURTHER if carry else more)))
    # Last: a mistake in the command is told whatever else is running.
    check_port(router, robot)
    stop = stop_event()
    with Children() as children, tempfile.TemporaryDirectory(prefix="tandem-") as folder:
        if carry:
            run = carry_protocol.run("certified", "omni")
            config, more = write_config(run.settings, Path(folder) / "carry.toml"), run.further
        plan = Plan(robot, router, config, parsed, more, links, robot_process)
        stack = StackProcesses(plan, children)
        try:
            wait_for_router(stack.processes[ROUTER])
            with open_bus(robot, router, ROUTER_WITHIN, lambda: stop.is_set() or ROUTER in stack.ended()) as bus:
                _show(stack, Watch(bus), stop, Page(view, robot, router, children))
        finally:
            plan.forget()
        hard = children.stop()
    typer.echo("all processes ended" if not hard else f"ended badly: {', '.join(_bad(child) for child in hard)}")
    if hard:
        raise typer.Exit(1)


def start(
    service: Annotated[str, typer.Argument(help=", ".join(STARTS), autocompletion=lambda: list(STARTS))],
    robot: Robot = DEFAULT_ROBOT,
    connect: Connect = DEFAULT_ENDPOINT,
    config: Config = None,
    settings: Annotated[list[str], typer.Option("--set", help="NAME=VALUE in TOML; repeatable.")] = [],  # noqa: B006
) -> None:
    """Run one service in the foreground with the options of the stack that it belongs to."""
    if service not in STARTS:
        refuse(f"{service!r} is no service of the stack; choose from {', '.join(STARTS)}")
    known = remembered(robot, connect) or Plan(robot, connect)
    given = {service: [*known.settings.get(service, []), *settings]}
    plan = replace(known, config=check_config(config) or known.config, settings=given)
    command = ["-m", process_named(service).module, *plan.arguments(service)]
    typer.echo(f"starting: python {' '.join(command)}", err=True)
    sys.stdout.flush()
    os.execv(sys.executable, [sys.executable, *command])


def _show(stack: StackProcesses, watch: Watch, stop: threading.Event, page: Page) -> None:
    console = Console()
    head = f"tandem: robot {stack.plan.robot} on {stack.plan.endpoint} (Ctrl-C stops everything)"
    if not console.is_terminal:
        _log(stack, watch, stop, head, page)
        return
    with Live(console=console, refresh_per_second=1 / REFRESH, transient=False) as live:
        while not stop.wait(REFRESH):
            stack.refuse_if_misconfigured()
            heads = "\n".join(filter(None, (head, page.said)))
            live.update(stack_view(_rows(stack, watch), watch, stack.processes, heads))


def _log(stack: StackProcesses, watch: Watch, stop: threading.Event, head: str, page: Page) -> None:
    """Without a terminal: one line per change."""
    typer.echo(head)
    shown: dict[str, str] = {}
    told = ""
    while not stop.wait(REFRESH):
        stack.refuse_if_misconfigured()
        if page.said != told:
            told = page.said
            typer.echo(told)
        for row in _rows(stack, watch):
            line = f"{row.service}: {row.state}" + (f": {row.detail}" if row.detail else "")
            if row.service not in shown or shown[row.service].split(":")[1] != line.split(":")[1]:
                typer.echo(f"{time.strftime('%H:%M:%S')} {line}")
            shown[row.service] = line


def _rows(stack: StackProcesses, watch: Watch) -> list[Row]:
    router = stack.processes[ROUTER]
    children = dict(zip(stack.plan.expected, map(stack.processes.get, stack.plan.services), strict=True))
    rows = diagnose.rows(watch.living(), watch.health(), stack.plan.expected)
    rows = [_with_process(row, children.get(row.service)) for row in rows]
    listens = router.status is None
    return [_with_process(Row(ROUTER, "ok" if listens else "lost", "", listens), router), *rows]


def _with_process(row: Row, child: Child | None) -> Row:
    """Adds what the process tells: how it ended, or that it has just been started and need not have spoken yet."""
    if child is None or row.ok:
        return row
    if child.status is not None:
        again = "" if child.status == SECOND else f"; start it again with: tandem start {child.name}"
        return replace(row, detail=f"{child.how_it_ended()}{again}")
    if row.health is None and time.monotonic() - child.started < SPEAKS_WITHIN:
        return replace(row, state="starting", detail="not heard yet", ok=True)
    if row.state in ("lost", "silent"):
        return replace(row, detail=f"its process runs (pid {child.pid}), but nothing is heard of it")
    return row


def _bad(child: Child) -> str:
    return f"{child.name} (status {child.status})"
