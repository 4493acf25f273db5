"""How the robot's topics differ from its profile, one line each, as the liveliness tokens on its network tell it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from services.bridge_ros2.names import End


def heard(ends: Iterable[End], kinds: Mapping[str, str], shared: str) -> Iterator[str]:
    """Of the topics that the robot publishes.

    Args:
        ends: whatever publishes and subscribes on the network.
        kinds: types by topic, as the profile has them.
        shared: a topic that may have several publishers.
    """
    for topic, kind in kinds.items():
        publishers = sorted((end for end in ends if end.publishes and end.topic == topic), key=lambda end: end.node)
        if not publishers:
            yield f"nobody publishes {topic} ({kind}): is that part of the robot up, and is it called so there?"
        elif other := next((end for end in publishers if end.kind != kind), None):
            yield f"{topic} is {other.kind} on the robot ({other.node}), the profile says {kind}"
        elif len(publishers) > 1 and topic != shared:
            names = " and ".join(end.node for end in publishers)
            yield f"{topic} has {len(publishers)} publishers, {names}: one of them has to go"


def commanded(ends: Iterable[End], kinds: Mapping[str, str], hashes: Mapping[str, str]) -> Iterator[str]:
    """Of the topics that the robot is commanded by.

    Args:
        ends: whatever else publishes and subscribes on the network.
        kinds: types by topic, as the profile has them.
        hashes: by type, as the bridge publishes under.
    """
    for topic, kind in kinds.items():
        listeners = [end for end in ends if not end.publishes and end.topic == topic]
        others = sorted({end.node for end in ends if end.publishes and end.topic == topic})
        if not listeners:
            yield f"nobody listens to {topic} ({kind}): is that controller loaded, and is it called so there?"
        elif other := next((end for end in listeners if end.kind != kind), None):
            yield f"{topic} is {other.kind} on the robot ({other.node}), the profile says {kind}: nothing arrives there"
        elif other := next((end for end in listeners if end.hash not in ("", hashes[kind])), None):
            yield (
                f"{other.node} listens to {topic} under the type hash {other.hash[:16]}, which is another release of "
                'ROS 2 than the bridge speaks: --set distribution="humble" or "jazzy"'
            )
        if others:
            yield f"{topic} is commanded by {', '.join(others)}, too"
