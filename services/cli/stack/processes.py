"""A stack as processes: started together, looked after, stopped together."""

from __future__ import annotations

import time
from pathlib import Path

from services.cli.refusal import refuse
from services.cli.stack.children import Child, Children
from services.cli.stack.plan import ROUTER, Plan

EARLY = 0.3  # [s] within which a process that cannot work with its options ends


class Stack:
    """The processes of one plan. Nothing is restarted: what ended stays ended until the user starts it again."""

    def __init__(
        self, plan: Plan, children: Children, logs: Path | None = None, with_router: bool = True
    ) -> None:
        """Starts the processes; their output goes to files in `logs` as well. `children` ends them."""
        self.plan = plan
        self.processes: dict[str, Child] = {}
        if with_router:
            self.processes[ROUTER] = children.start(_child(ROUTER, plan.router_arguments(), plan, logs))
        for service in plan.services:
            child = _child(service, plan.arguments(service), plan, logs)
            self.processes[service] = children.start(child)
        plan.remember()

    def ended(self) -> dict[str, Child]:
        """The processes that have ended."""
        return {name: child for name, child in self.processes.items() if child.status is not None}

    def refuse_if_misconfigured(self) -> None:
        """Ends the command when a process has refused its configuration (status 2), with the line that it printed."""
        for name, child in self.ended().items():
            if child.status == 2:
                refuse(f"{name} {child.how_it_ended()}")

    def wait_for_router(self, within: float = 5.0) -> None:
        """Returns when the router has had time to refuse; refuses when it did."""
        router = self.processes.get(ROUTER)
        deadline = time.monotonic() + min(within, EARLY)
        while router is not None and time.monotonic() < deadline:
            if router.status is not None:
                refuse(f"{ROUTER} {router.how_it_ended()}", 1)
            time.sleep(0.02)


def _child(name: str, arguments: list[str], plan: Plan, logs: Path | None) -> Child:
    return Child(name, arguments, logs / f"{name}.log" if logs else None)
