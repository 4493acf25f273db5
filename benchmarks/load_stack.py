"""The load experiment with all services in one process under a simulated clock."""

from __future__ import annotations

import tempfile
from pathlib import Path

from services.controller.controller import Controller
from services.controller.parameters import ControllerParameters
from services.experiment.experiment import Answered, LoadExperiment
from services.experiment.protocol import Run
from services.experiment.recording import Recording
from services.experiment.sequence import Ask
from services.sim.parameters import SimParameters
from services.sim.simulator import Simulator
from services.wrench.parameters import WrenchParameters
from services.wrench.wrench import Wrench
from shared.codec import decode_map, encode_map
from shared.stack import Stack

LATENCY = 0.0005  # [s] of every message, about what the router takes
LONGEST = 180.0  # [s] of simulated time for one run, settling included


def play(run: Run) -> Recording:
    """Plays one run in simulated time.

    Raises:
        services.experiment.sequence.Failed: the experiment could not be completed.
        TimeoutError: it did not end.
    """
    with tempfile.TemporaryDirectory() as folder:
        stack = Stack(LATENCY)
        settings = run.settings
        stack.add(Simulator(SimParameters.of(settings.get("sim", {}))))
        stack.add(Wrench(WrenchParameters.of(settings.get("wrench", {})), Path(folder)))
        stack.add(Controller(ControllerParameters.of(settings.get("controller", {}))))
        experiment = LoadExperiment(
            run, stack.bus, stack.scheduler.clock, lambda ask, answered: _ask(stack, ask, answered)
        )
        stack.add(experiment)
        stack.run(LONGEST, done=lambda: experiment.finished)
    if not experiment.finished:
        raise TimeoutError(
            f"{run.name}: still {experiment.sequence.phase} after {LONGEST:g} s of simulated time"
        )
    return experiment.recording(bus="in-process, simulated time")


def _ask(stack: Stack, ask: Ask, answered: Answered) -> None:
    served = stack.bus.query_later(
        ask.query.key, encode_map(ask.request), lambda payload: answered(decode_map(payload))
    )
    if not served:
        answered({"ok": False, "error": f"nobody serves {ask.query.key}"})
