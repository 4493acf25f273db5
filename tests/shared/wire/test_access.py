"""Access control against the contract's tables, by the rules as Zenoh applies them to what comes in."""

from __future__ import annotations

import pytest

from shared.processes import PROCESSES
from shared.topics import ANYBODY, QUERIES, TOPICS
from shared.wire.access import PARTICIPANTS, access, common_name

ROBOTS = ("tiago", "reem")
CONFIG = access(ROBOTS)


def matches(pattern: str, key: str) -> bool:
    wanted, given = pattern.split("/"), key.split("/")
    if wanted[-1] == "**":
        return given[: len(wanted) - 1] == wanted[:-1]
    return len(wanted) == len(given) and all(one in ("*", other) for one, other in zip(wanted, given, strict=True))


def allowed(name: str, message: str, key: str) -> bool:
    """Whether a message of one kind may come in under a key from a certificate's name."""
    rules = {rule["id"]: rule for rule in CONFIG["rules"]}
    mine = [rules[rule] for policy in CONFIG["policies"] if name in policy["subjects"] for rule in policy["rules"]]
    return any(
        rule["flows"] == ["ingress"]
        and message in rule["messages"]
        and any(matches(pattern, key) for pattern in rule["key_exprs"])
        for rule in mine
    )


@pytest.mark.parametrize("participant", PARTICIPANTS)
def test_each_says_what_the_table_lets_it_say(participant: str) -> None:
    speaks = {process.name: process.publisher for process in PROCESSES}.get(participant, participant)
    for topic in TOPICS:
        expected = (ANYBODY in topic.publishers or speaks in topic.publishers) and participant != "viewer"
        if participant == "operator":
            expected = topic.key in ("stop", "control/target", "operator/enable")
        assert allowed(common_name("tiago", participant), "put", f"tiago/{topic.key}") == expected, topic.key
        assert not allowed(common_name("tiago", participant), "put", f"reem/{topic.key}")


@pytest.mark.parametrize("participant", PARTICIPANTS)
def test_only_the_server_answers_and_only_a_person_asks(participant: str) -> None:
    speaks = {process.name: process.publisher for process in PROCESSES}.get(participant, participant)
    name = common_name("tiago", participant)
    for query in QUERIES:
        key = f"tiago/{query.key}"
        assert allowed(name, "declare_queryable", key) == allowed(name, "reply", key) == (speaks in query.servers)
        asks = participant in ("operator", "experiment")
        asks |= participant == "page" and query.key in ("task/command", "sim/command")
        assert allowed(name, "query", key) == asks


@pytest.mark.parametrize("participant", PARTICIPANTS)
def test_a_token_and_a_health_are_one_s_own(participant: str) -> None:
    name = common_name("tiago", participant)
    for other in PARTICIPANTS:
        assert allowed(name, "liveliness_token", f"tiago/alive/{other}/17") == (other == participant)
        own = other == participant and participant not in ("operator", "viewer", "page")
        for kind in ("health", "setup"):
            assert allowed(name, "put", f"tiago/{kind}/{other}") == own


def test_all_read_and_none_reads_another_robot() -> None:
    for participant in PARTICIPANTS:
        name = common_name("tiago", participant)
        assert allowed(name, "declare_subscriber", "tiago/wrench/external")
        assert not allowed(name, "declare_subscriber", "reem/wrench/external")


def test_a_stranger_may_nothing_and_what_is_not_named_is_denied() -> None:
    assert CONFIG["default_permission"] == "deny"
    assert not any(allowed("stranger", message, "tiago/stop") for message in ("put", "declare_subscriber", "query"))
