"""The table of topics against the contract, which is written down here once more, by hand and not from the code.

``force[3]`` is a vector, ``[n]`` one of any length, a bare name a number, ``?`` what may be null, ``~`` what the
contract leaves free: readers do without it.
"""

from __future__ import annotations

import itertools

import pytest

from shared.messages import Header
from shared.schema.fields import Anything, Kind, Vector
from shared.schema.records import MapOf, Nullable, Record, RecordOf
from shared.topics import QUERIES, TOPICS, WRENCH_EXTERNAL, health_topic, topic_by_key

POSE = "position[3] orientation[4]"
CONTRACT: dict[str, tuple[str, int | None, str]] = {
    "sensor/ft": ("robot", 100, "force[3] torque[3] orientation[4] tool_offset[3] saturated:bool ~gravity[3]"),
    "sensor/camera": (
        "robot",
        10,
        f"width:int height:int encoding:jpeg/png/rgb8/bgr8/mono8 data:bytes intrinsics[4] distortion[n] {POSE} "
        "~distortion_model:text",
    ),
    "state/joints": ("robot", 100, "name:texts position[n] velocity[n] effort[n]"),
    "state/ee": ("robot", 100, f"{POSE} linear[3] angular[3]"),
    "state/base": ("robot", 50, "position[2] yaw velocity[3]"),
    "state/gripper": ("robot", 20, "opening effort holding:bool"),
    "state/robot": (
        "robot",
        5,
        "mode:ready/holding/stopped reason:text base_type:differential/omni simulated:bool max_linear max_angular "
        "max_base[3] ~held:int ~require_enable:bool",
    ),
    "command/ee_twist": ("controller", None, "linear[3] angular[3] ttl"),
    "command/base_twist": ("base", None, "velocity[3] ttl"),
    "command/gripper": ("task", None, "opening effort"),
    "command/head": ("task", None, "pan tilt"),
    "stop": ("*", None, "engaged:bool reason:text"),
    "operator/enable": ("operator or page", 20, "pressed:bool"),
    "wrench/external": (
        "wrench",
        None,
        "force[3] torque[3] error_bound[6] compensation:none/tare/payload fault:text ~zero_age?",
    ),
    "control/target": (
        "task or experiment",
        None,
        f"{POSE} force_limit[3] torque_limit[3] nominal_force[3] nominal_torque[3]",
    ),
    "control/status": (
        "controller",
        None,
        "state:waiting/tracking/yielding/braking reason:text law:certified/paper/stiffness twist[6] margin[6] "
        "active[6] relaxation lyapunov solve_us ~limit?[6] ~nominal?[6]",
    ),
    "base/status": ("base", None, "state:off/following/braking wrench[3] velocity[3]"),
    "base/enable": ("task", None, "enabled:bool"),
    "task/status": ("task", None, f"state:text since reason:text rotation height marker?{{{POSE} age}}"),
    "sim/world": (
        "robot or ros_robot",
        30,
        f"time panel?{{{POSE} ~size[3]}} bag?{{mass height}} "
        "hand?{position[3] force[3] torque[3] ~doing:text ~wanted[3] "
        "~wanted_orientation[4]} contact_force[3] marker_visible:bool",
    ),
    "health/wrench": (
        "wrench",
        2,
        "state:starting/ok/degraded/fault detail:text loop_hz loop_p50_us loop_p99_us overruns:int "
        "inputs:{text: {age hz rejected:int ok:bool}} ~links:{text: :bool}",
    ),
}
"""Publisher, rate [Hz] if the contract states one, and fields."""
TABLE = "parameters:{text: {value:any unit:text min? max? doc:text}}"
QUERYABLES: dict[str, tuple[str, dict[str, tuple[str, str]]]] = {
    "wrench/tare": (
        "wrench",
        {"": ("duration ~force:bool", "force[3] torque[3] samples:int std[6] ~replaced_age ~warning:text")},
    ),
    "wrench/identify": (
        "wrench",
        {
            "start": ("", "poses:int"),
            "add": ("duration", "poses:int samples:int std[6]"),
            "solve": (
                "~force:bool",
                "mass com[3] force_bias[3] torque_bias[3] sigma[n] residual_rms[6] condition poses:int file:text "
                "~warning:text",
            ),
            "cancel": ("", "poses:int"),
        },
    ),
    "task/command": ("task", {"": ("command:start/abort/release/reset", "state:text")}),
    "wrench/parameters": ("wrench", {"": ("set?:map", TABLE)}),
    "control/parameters": ("controller", {"": ("set?:map", TABLE)}),
    "base/parameters": ("base", {"": ("set?:map", TABLE)}),
    "sim/command": (
        "robot or ros_robot",
        {
            "reset": ("", ""),
            "load": ("mass", ""),
            "push": ("duration force[3] torque[3]", ""),
            "hand": ("script?:text target?[3]", ""),
            "cover_marker": ("covered:bool", ""),
            "fault": ("target:ft/camera/joints kind:off/stuck/garbage/bias/delay/ok value:any", ""),
        },
    ),
}
"""Server, and for each word that begins a request the fields of request and reply."""
SCALARS = {
    "Number": "",
    "Integer": ":int",
    "Boolean": ":bool",
    "Bytes": ":bytes",
    "TextList": ":texts",
    "Anything": ":any",
}


def fields_of(record: type[Record]) -> str:
    return " ".join(name + shape(kind) for name, kind, _ in record.kinds())


def shape(kind: Kind) -> str:
    if isinstance(kind, RecordOf):
        return f"{{{fields_of(kind.record)}}}"
    if isinstance(kind, MapOf):
        return ":map" if isinstance(kind.kind, Anything) else f":{{text: {shape(kind.kind)}}}"
    if isinstance(kind, Nullable):
        return "?" + shape(kind.kind)
    name = type(kind).__name__
    if isinstance(kind, Vector):
        return f"[{kind.size or 'n'}]"
    if name == "Text":
        return ":" + ("/".join(kind.choices) or "text")
    return SCALARS[name]


@pytest.mark.parametrize("key", CONTRACT)
def test_a_topic_is_as_the_contract_says(key: str) -> None:
    publisher, rate, fields = CONTRACT[key]
    topic = topic_by_key(key)
    assert topic is not None
    assert topic.publisher == publisher
    assert fields_of(topic.message) == fields.replace("~", "")
    assert topic.cap == (4 * 1024**2 if key == "sensor/camera" else 64 * 1024)
    assert rate in (None, topic.rate)


def test_no_topic_of_the_contract_is_missing() -> None:
    """Further ones are free; docs/contract.md, which is generated, shows them to whoever reads the change."""
    assert {topic.key for topic in TOPICS} | {"health/wrench"} >= set(CONTRACT)


@pytest.mark.parametrize(("key", "word"), [(key, word) for key, (_, words) in QUERYABLES.items() for word in words])
def test_a_query_is_as_the_contract_says(key: str, word: str) -> None:
    server, words = QUERYABLES[key]
    query = next(query for query in QUERIES if query.key == key)
    assert query.server == server
    assert set(query.exchanges) == set(words)
    request, reply = query.exchanges[word]
    assert [fields_of(request), fields_of(reply)] == [fields.replace("~", "") for fields in words[word]]


def test_the_header() -> None:
    assert fields_of(Header) == "seq:int session:int stamp:int valid:bool"


def test_a_periodic_topic_may_be_read_for_three_periods_at_least() -> None:
    assert all(topic.max_age >= 3 / topic.rate - 1e-9 for topic in TOPICS if topic.rate)


def test_keys_are_distinct_and_found() -> None:
    keys = [topic.key for topic in TOPICS] + [query.key for query in QUERIES]
    assert all(a != b for a, b in itertools.combinations(keys, 2))
    assert topic_by_key("wrench/external") is WRENCH_EXTERNAL
    assert topic_by_key("health/controller") == health_topic("controller")
    assert topic_by_key("command/nothing") is None
