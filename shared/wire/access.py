"""Access control of the closed network: what each certificate may do, derived from the tables, and nothing else.

A participant is known by the common name of its certificate, ``<robot>.<participant>``. Every process that listens
holds whoever dials it against the same rules, the processes of the chain like the router, which sees no direct links.

What Zenoh wants of a message's way (1.10.2): a put comes in from whoever publishes, and goes out to whoever reads; the
reader's declaration comes in from the reader and has to go out to the publisher, or nothing is sent. So everything may
go out to whoever has a certificate of that robot, and what comes in decides.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from shared.processes import HEALTHY, ROUTER, publisher_named
from shared.topics import (
    ANYBODY,
    CONTROL_TARGET,
    OPERATOR,
    PAGE,
    QUERIES,
    ROBOT,
    SIM_COMMAND,
    TASK_COMMAND,
    TOPICS,
    Query,
    Topic,
)

ASKERS = (OPERATOR, "experiment")
"""Participants that may send every query: nothing in the chain asks anything."""
READER = "viewer"
"""A participant that may only read."""
PAGE_ASKS = (TASK_COMMAND, SIM_COMMAND)
"""What the person's page may ask: what its buttons stand for."""
PARTICIPANTS = (*(name for name in HEALTHY if name != ROUTER.name), OPERATOR, READER, PAGE)
SILENT = (OPERATOR, READER, PAGE)
"""Participants that tell no health."""
_SAY = ("put", "delete")
_SERVE = ("reply", "declare_queryable")
_READ = ("declare_subscriber", "liveliness_query", "declare_liveliness_subscriber")
_TOKEN = ("liveliness_token",)
_ASK = ("query",)
_EVERYTHING = (*_SAY, *_SERVE, *_READ, *_TOKEN, *_ASK)


def common_name(robot: str, participant: str) -> str:
    """Common name of a participant's certificate; the router's is the same for all robots."""
    return participant if participant == ROUTER.name else f"{robot}.{participant}"


def participant_of(common: str) -> str:
    """Whose certificate it is, by its common name."""
    return common.rpartition(".")[2]


def may_publish(participant: str, topic: Topic) -> bool:
    """Whether a participant may say something under a topic."""
    if participant == READER:
        return False
    if ANYBODY in topic.publishers:
        return True
    if participant == OPERATOR and topic is CONTROL_TARGET:
        return True  # it leads the tool as an experiment may
    return publisher_named(participant) in topic.publishers


def may_ask(participant: str, query: Query) -> bool:
    """Whether a participant may send a query."""
    return participant in ASKERS or (participant == PAGE and query in PAGE_ASKS)


def may_serve(participant: str, query: Query) -> bool:
    """Whether a participant may answer a query."""
    return publisher_named(participant) in query.servers


def access(robots: Sequence[str]) -> dict[str, Any]:
    """``access_control`` of a Zenoh configuration for the networks of these robots."""
    rules: list[dict[str, Any]] = []
    subjects: list[dict[str, Any]] = []
    policies: list[dict[str, Any]] = []
    for robot in robots:
        everything = [f"{robot}/**"]
        rules.append(_rule(f"{robot} out", "egress", _EVERYTHING, everything))
        rules.append(_rule(f"{robot} read", "ingress", _READ, everything))
        rules.append(_rule(f"{robot} routed", "ingress", _EVERYTHING, everything))
        for participant in PARTICIPANTS:
            own = [
                _rule(f"{robot} {participant} {what}", "ingress", messages, [f"{robot}/{key}" for key in keys])
                for what, messages, keys in _own(participant)
            ]
            rules += own
            name = common_name(robot, participant)
            subjects.append({"id": name, "cert_common_names": [name]})
            shared = [f"{robot} out", f"{robot} read"]
            policies.append({"rules": [*shared, *(rule["id"] for rule in own)], "subjects": [name]})
    # It speaks for those who are its clients, whom it has held against these rules itself.
    subjects.append({"id": ROUTER.name, "cert_common_names": [ROUTER.name]})
    routed = [f"{robot} {what}" for robot in robots for what in ("out", "routed")]
    policies.append({"rules": routed, "subjects": [ROUTER.name]})
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": rules,
        "subjects": subjects,
        "policies": policies,
    }


def _own(participant: str) -> Iterator[tuple[str, tuple[str, ...], list[str]]]:
    """Rules of a participant's own: a word for each, the messages, and the keys without the robot; none is empty."""
    said = [topic.key for topic in TOPICS if may_publish(participant, topic)]
    if participant not in SILENT:
        said += [f"health/{participant}", f"setup/{participant}"]
    if publisher_named(participant) == ROBOT:
        # What a robot sends to itself, to see whether the router hands it on.
        said.append("beat/*")
    for what, messages, keys in (
        ("says", _SAY, said),
        ("serves", _SERVE, [query.key for query in QUERIES if may_serve(participant, query)]),
        ("asks", _ASK, [query.key for query in QUERIES if may_ask(participant, query)]),
        ("lives", _TOKEN, [f"alive/{participant}", f"alive/{participant}/*"]),
    ):
        if keys:
            yield what, messages, keys


def _rule(name: str, flow: str, messages: Sequence[str], keys: Sequence[str]) -> dict[str, Any]:
    return {"id": name, "permission": "allow", "flows": [flow], "messages": [*messages], "key_exprs": [*keys]}
