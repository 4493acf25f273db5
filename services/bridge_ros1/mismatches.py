"""How the robot's topics differ from its profile, one line each, as the master and the connections tell it."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence

from services.bridge_ros1.commands import Outlet
from services.bridge_ros1.master import Graph
from services.bridge_ros1.node import Ear


def heard(graph: Graph, ears: Sequence[Ear]) -> Iterator[str]:
    """Of the topics that the robot publishes."""
    for ear in ears:
        topic, publishers = ear.topic, graph.publishers.get(ear.topic, ())
        kind = graph.types.get(topic, ear.kind)
        if not publishers:
            yield f"nobody publishes {topic} ({ear.kind}): is that part of the robot up, and is it called so there?"
        elif kind != ear.kind:
            yield f"{topic} is {kind} on the robot ({', '.join(publishers)}), the profile says {ear.kind}"
        elif len(publishers) > 1 and not ear.shared:
            yield f"{topic} has {len(publishers)} publishers, {' and '.join(publishers)}: one of them has to go"
        elif not ear.publishers:
            yield f"{publishers[0]} publishes {topic}, but cannot be reached from here: is its machine known here?"


def commanded(graph: Graph, outlets: Sequence[Outlet], own: str) -> Iterator[str]:
    """Of the topics that the robot is commanded by.

    Args:
        graph: of the robot.
        outlets: of the bridge.
        own: name of its node.
    """
    for outlet in outlets:
        topic, listeners = outlet.topic, graph.subscribers.get(outlet.topic, ())
        kind = graph.types.get(topic, outlet.kind)
        if kind != outlet.kind:
            yield f"{topic} is {kind} on the robot, the profile says {outlet.kind}: nothing is sent there"
        elif not listeners:
            yield f"nobody listens to {topic} ({outlet.kind}): is that controller loaded, and is it called so there?"
        elif not outlet.listeners:
            yield (
                f"{listeners[0]} listens to {topic}, but has not connected: does its {topic} have another type, "
                f"or does its machine not reach {os.environ.get('ROS_IP') or os.environ.get('ROS_HOSTNAME')} (ROS_IP)?"
            )
        others = [name for name in graph.publishers.get(topic, ()) if name != own]
        if others:
            yield f"{topic} is commanded by {', '.join(others)}, too"
