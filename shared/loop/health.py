"""The health message of a service: a function of its loop's parts."""

from __future__ import annotations

import math
from collections.abc import Mapping

from shared.faults import Fault, FaultKind
from shared.loop.timing import LoopTiming
from shared.messages import Health, InputHealth
from shared.service import Service
from shared.wire.subscription import Subscription


def health(
    now_ns: int,
    service: Service,
    fault: Fault | None,
    timing: LoopTiming,
    subscriptions: Mapping[str, Subscription],
    taken: Mapping[str, str],
    links: Mapping[str, bool],
    remark: str = "",
) -> Health:
    """How a service is.

    Args:
        now_ns: steady clock [ns].
        service: asked for its notes and what it requires.
        fault: that is present, if any.
        timing: of its loop.
        subscriptions: its inputs, by key.
        taken: by key, who else publishes what it publishes, and was first.
        links: whether there is a direct link to each other process of the chain.
        remark: on the process, which is as well as before all the same.
    """
    own = service.notes() if fault is None else fault.text
    unused = {key: refused.text for key, one in subscriptions.items() if (refused := one.refused(now_ns))}
    seconds = [(key, second) for key, one in subscriptions.items() if (second := one.second(now_ns))]
    more = [
        *unused.items(),
        *((key, f"{key}: {two} publishes it too and is refused, since {one} was first") for key, (two, one) in seconds),
        *(
            (key, f"{key}: {who} publishes it and was first: what comes from here is refused")
            for key, who in taken.items()
        ),
    ]
    detail = "; ".join(filter(None, (own, *(text for key, text in more if key not in own))))
    if fault is None:
        state = "degraded" if detail else "ok"
    elif fault.waiting:
        state = "starting"
    else:
        state = "fault" if fault.kind is FaultKind.INTERNAL else "degraded"
    required = {topic.key for topic in service.wiring.required}
    publishers = {topic.key: topic.publishers for topic in service.wiring.required}
    needed = {name: up for names in publishers.values() for name in names if (up := links.get(name)) is not None}
    # Who has no link may speak through the router, as a client: its absence is a cause only where something is missing.
    if fault and (missing := [name for name in publishers.get(fault.key, ()) if needed.get(name) is False]):
        detail += f"; there is no direct link to {' or '.join(missing)}"
    detail = "; ".join(filter(None, (detail, remark)))
    inputs = {}
    for key, subscription in subscriptions.items():
        # What may be missing, and what holds until it is replaced, has no fault by being silent.
        judged = key in required or (subscription.latest is not None and subscription.topic.max_age < math.inf)
        inputs[key] = InputHealth(
            age=subscription.age(now_ns),
            hz=subscription.rate(now_ns),
            rejected=subscription.rejected + subscription.out_of_order + subscription.second_session,
            ok=key not in unused and (not judged or subscription.fault(now_ns, service.max_delay) is None),
        )
    return Health(state, detail, *timing.summary(now_ns), timing.overruns, inputs, needed)
