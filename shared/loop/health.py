"""The health message of a service: a function of its loop's parts."""

from __future__ import annotations

import math
from collections.abc import Mapping

from shared.faults import Fault, FaultKind
from shared.loop.timing import LoopTiming
from shared.messages import Health, InputHealth
from shared.service import Service
from shared.wire.subscription import Inlet


def health(
    now_ns: int, service: Service, fault: Fault | None, timing: LoopTiming, inlets: Mapping[str, Inlet]
) -> Health:
    """How a service is.

    Args:
        now_ns: steady clock [ns].
        service: asked for its notes and what it requires.
        fault: that is present, if any.
        timing: of its loop.
        inlets: its inputs, by key.
    """
    notes = service.notes()
    if fault is None:
        state, detail = ("degraded", notes) if notes else ("ok", "")
    elif fault.waiting:
        state, detail = "starting", fault.text
    else:
        state, detail = ("fault" if fault.kind is FaultKind.INTERNAL else "degraded"), fault.text
    required = {topic.key for topic in service.wiring.required}
    inputs = {}
    for key, inlet in inlets.items():
        # What may be missing, and what holds until it is replaced, has no fault by being silent.
        judged = key in required or (inlet.latest is not None and inlet.topic.max_age < math.inf)
        inputs[key] = InputHealth(
            age=inlet.age(now_ns),
            hz=inlet.rate(now_ns),
            rejected=inlet.rejected + inlet.out_of_order + inlet.second_session,
            ok=not judged or inlet.fault(now_ns, service.max_delay) is None,
        )
    return Health(state, detail, *timing.summary(now_ns), timing.overruns, inputs)
