"""A stack as processes: started together, looked after, stopped together."""

from __future__ import annotations

import time
from pathlib import Path

from services.cli.common import refuse
from services.cli.stack.children import Child, Children
from services.cli.stack.plan import Plan
from shared.processes import ROUTER

EARLY = 0.3  # [s] within which a router that cannot listen ends


class StackProcesses:
    """The processes of one plan. Nothing is restarted: what ended stays ended until the user starts it again."""

    def __init__(self, plan: Plan, children: Children, logs: Path | None = None, with_router: bool = True) -> None:
        """Starts the processes; their output goes to files in `logs` as well. `children` ends them."""
        self.plan = plan
        self.processes = {
            name: children.start(Child(name, plan.arguments(name), logs / f"{name}.log" if logs else None))
            for name in (*([ROUTER.name] if with_router else []), *plan.services)
        }
        plan.remember()

    def ended(self) -> dict[str, Child]:
        """The processes that have ended."""
        return {name: child for name, child in self.processes.items() if child.status is not None}

    def refuse_if_misconfigured(self) -> None:
        """Ends the command when a process has refused its configuration (status 2), with the line that it printed."""
        for name, child in self.ended().items():
            if child.status == 2:
                refuse(f"{name} {child.how_it_ended()}")


def start_router(children: Children, endpoint: str, folder: Path) -> None:
    """Starts a router by itself; refuses if it cannot listen."""
    arguments = ROUTER.arguments("", endpoint)
    wait_for_router(children.start(Child(ROUTER.name, arguments, folder / f"{ROUTER.name}.log")))


def wait_for_router(router: Child) -> None:
    """Returns when the router has had time to refuse; refuses when it did."""
    deadline = time.monotonic() + EARLY
    while time.monotonic() < deadline:
        if router.status is not None:
            refuse(f"{ROUTER.name} {router.how_it_ended()}", 1)
        time.sleep(0.02)
