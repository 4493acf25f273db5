"""The table of topics against the contract, which is written down here once more, by hand and not from the code."""

from __future__ import annotations

import itertools

import pytest

from shared.messages import Header
from shared.schema.records import MapOf, Nullable, RecordOf
from shared.topics import (
    ANYBODY,
    QUERIES,
    ROBOT,
    TOPICS,
    WRENCH_EXTERNAL,
    health_topic,
    topic_by_key,
)

V2, V3, V4, V5, V6, VN = 2, 3, 4, 5, 6, "n"
"""Lengths of vectors."""

CONTRACT: dict[str, tuple[str, dict[str, object]]] = {
    "sensor/ft": (
        ROBOT,
        {"force": V3, "torque": V3, "orientation": V4, "tool_offset": V3, "saturated": bool},
    ),
    "sensor/camera": (
        ROBOT,
        {
            "width": int,
            "height": int,
            "encoding": {"jpeg", "rgb8"},
            "data": bytes,
            "intrinsics": V4,
            "distortion": V5,
            "position": V3,
            "orientation": V4,
        },
    ),
    "state/joints": (ROBOT, {"name": list, "position": VN, "velocity": VN, "effort": VN}),
    "state/ee": (ROBOT, {"position": V3, "orientation": V4, "linear": V3, "angular": V3}),
    "state/base": (ROBOT, {"position": V2, "yaw": float, "velocity": V3}),
    "state/gripper": (ROBOT, {"opening": float, "effort": float, "holding": bool}),
    "state/robot": (
        ROBOT,
        {
            "mode": {"ready", "holding", "stopped"},
            "reason": str,
            "base_type": {"differential", "omni"},
            "simulated": bool,
            "max_linear": float,
            "max_angular": float,
            "max_base": V3,
        },
    ),
    "command/ee_twist": ("controller", {"linear": V3, "angular": V3, "ttl": float}),
    "command/base_twist": ("base", {"velocity": V3, "ttl": float}),
    "command/gripper": ("task", {"opening": float, "effort": float}),
    "command/head": ("task", {"pan": float, "tilt": float}),
    "stop": (ANYBODY, {"engaged": bool, "reason": str}),
    "wrench/external": (
        "wrench",
        {
            "force": V3,
            "torque": V3,
            "error_bound": V6,
            "compensation": {"none", "tare", "payload"},
            "fault": str,
        },
    ),
    "control/target": (
        "task or experiment",
        {
            "position": V3,
            "orientation": V4,
            "force_limit": V3,
            "torque_limit": V3,
            "nominal_force": V3,
            "nominal_torque": V3,
        },
    ),
    "control/status": (
        "controller",
        {
            "state": {"waiting", "tracking", "yielding", "braking"},
            "reason": str,
            "law": {"certified", "paper", "stiffness"},
            "twist": V6,
            "margin": V6,
            "active": V6,
            "relaxation": float,
            "lyapunov": float,
            "solve_us": float,
        },
    ),
    "base/status": ("base", {"state": {"off", "following", "braking"}, "wrench": V3, "velocity": V3}),
    "base/enable": ("task", {"enabled": bool}),
    "task/status": (
        "task",
        {
            "state": str,
            "since": float,
            "reason": str,
            "rotation": float,
            "height": float,
            "marker": (None, {"position": V3, "orientation": V4, "age": float}),
        },
    ),
    "sim/world": (
        ROBOT,
        {
            "time": float,
            "panel": (None, {"position": V3, "orientation": V4}),
            "bag": (None, {"mass": float, "height": float}),
            "hand": (None, {"position": V3, "force": V3, "torque": V3}),
            "contact_force": V3,
            "marker_visible": bool,
        },
    ),
    "health/wrench": (
        "wrench",
        {
            "state": {"starting", "ok", "degraded", "fault"},
            "detail": str,
            "loop_hz": float,
            "loop_p50_us": float,
            "loop_p99_us": float,
            "overruns": int,
            "inputs": [{"age": float, "hz": float, "rejected": int, "ok": bool}],
        },
    ),
}
FREE: dict[str, dict[str, object]] = {
    "state/robot": {"held": int},
    "sim/world": {
        "hand": (
            None,
            {
                "position": V3,
                "force": V3,
                "torque": V3,
                "doing": str,
                "wanted": V3,
                "wanted_orientation": V4,
            },
        )
    },
}
"""What stands beside the contract's fields, which leaves free whatever it does not name; readers do without."""
RATES = {
    "sensor/ft": 100,
    "sensor/camera": 10,
    "state/joints": 100,
    "state/ee": 100,
    "state/base": 50,
    "state/gripper": 20,
    "state/robot": 5,
    "sim/world": 30,
    "health/wrench": 2,
}
IMAGES = {"sensor/camera"}
AVERAGE = {"samples": int, "std": V6}
PARAMETERS = (
    {"set": (None, dict)},
    {"parameters": [dict(value=object, unit=str, min=(None, float), max=(None, float), doc=str)]},
)
QUERYABLES: dict[str, tuple[str, dict[str, tuple[object, object]]]] = {
    "wrench/tare": ("wrench", {"": ({"duration": float}, {"force": V3, "torque": V3, **AVERAGE})}),
    "wrench/identify": (
        "wrench",
        {
            "start": ({}, {"poses": int}),
            "add": ({"duration": float}, {"poses": int, **AVERAGE}),
            "solve": (
                {},
                {
                    "mass": float,
                    "com": V3,
                    "force_bias": V3,
                    "torque_bias": V3,
                    "sigma": VN,
                    "residual_rms": V6,
                    "condition": float,
                    "poses": int,
                    "file": str,
                },
            ),
            "cancel": ({}, {"poses": int}),
        },
    ),
    "task/command": ("task", {"": ({"command": {"start", "abort", "release", "reset"}}, {"state": str})}),
    "wrench/parameters": ("wrench", {"": PARAMETERS}),
    "control/parameters": ("controller", {"": PARAMETERS}),
    "base/parameters": ("base", {"": PARAMETERS}),
    "sim/command": (
        ROBOT,
        {
            "reset": ({}, {}),
            "load": ({"mass": float}, {}),
            "push": ({"duration": float, "force": V3, "torque": V3}, {}),
            "hand": ({"script": (None, str), "target": (None, V3)}, {}),
            "cover_marker": ({"covered": bool}, {}),
            "fault": (
                {
                    "target": {"ft", "camera", "joints"},
                    "kind": {"off", "stuck", "garbage", "bias", "delay", "ok"},
                    "value": object,
                },
                {},
            ),
        },
    ),
}
SCALARS = {
    "Number": float,
    "Integer": int,
    "Boolean": bool,
    "Bytes": bytes,
    "TextList": list,
    "Anything": object,
    "AnyMap": dict,
}


def fields_of(record) -> dict[str, object]:
    return {name: shape(kind) for name, kind, _ in record.kinds()}


def shape(kind) -> object:
    if isinstance(kind, RecordOf):
        inner = fields_of(kind.record)
        return (None, inner) if kind.nullable else inner
    if isinstance(kind, MapOf):
        return [fields_of(kind.record)]
    if isinstance(kind, Nullable):
        return (None, shape(kind.kind))
    name = type(kind).__name__
    if name in ("Vector", "Quaternion"):
        return VN if kind.size is None else kind.size
    if name == "Text":
        return set(kind.choices) if kind.choices else str
    return SCALARS[name]


@pytest.mark.parametrize("key", CONTRACT)
def test_a_topic_is_as_the_contract_says(key: str) -> None:
    publisher, fields = CONTRACT[key]
    topic = topic_by_key(key)
    assert topic is not None
    assert topic.publisher == publisher
    assert fields_of(topic.message) == fields | FREE.get(key, {})
    assert topic.cap == (4 * 1024**2 if key in IMAGES else 64 * 1024)
    assert topic.rate == RATES.get(key, topic.rate)


def test_no_topic_of_the_contract_is_missing() -> None:
    """Further ones are free; docs/contract.md, which is generated, shows them to whoever reads the change."""
    assert {topic.key for topic in TOPICS} | {"health/wrench"} >= set(CONTRACT)


@pytest.mark.parametrize(
    ("key", "word"), [(key, word) for key, (_, words) in QUERYABLES.items() for word in words]
)
def test_a_query_is_as_the_contract_says(key: str, word: str) -> None:
    server, words = QUERYABLES[key]
    query = next(query for query in QUERIES if query.key == key)
    assert query.server == server
    assert set(query.exchanges) == set(words)
    request, reply = query.exchanges[word]
    assert (fields_of(request), fields_of(reply)) == words[word]


def test_the_header() -> None:
    assert fields_of(Header) == {
        "seq": int,
        "session": int,
        "stamp": int,
        "valid": bool,
    }


def test_a_periodic_topic_may_be_read_for_three_periods_at_least() -> None:
    assert all(topic.max_age >= 3 / topic.rate - 1e-9 for topic in TOPICS if topic.rate)


def test_keys_are_distinct_and_found() -> None:
    keys = [topic.key for topic in TOPICS] + [query.key for query in QUERIES]
    assert all(a != b for a, b in itertools.combinations(keys, 2))
    assert topic_by_key("wrench/external") is WRENCH_EXTERNAL
    assert topic_by_key("health/controller") == health_topic("controller")
    assert topic_by_key("command/nothing") is None
