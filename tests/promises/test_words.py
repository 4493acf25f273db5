"""What a process says of itself and answers: health, liveliness, status at the stated rates, parameters, nonsense."""

from __future__ import annotations

import math
from typing import Any

import msgpack
import pytest

from shared.parameters import Refused
from shared.topics import PARAMETER_QUERIES, SIM_COMMAND, TASK_COMMAND, WRENCH_IDENTIFY, WRENCH_TARE, Query
from tests.promises.subjects import SERVICES
from tests.promises.surroundings import PATIENCE, Surroundings
from tests.support.wait import eventually

pytestmark = pytest.mark.processes

NO_REQUEST = (b"\xc1", b"\x81", bytes(70_000), msgpack.packb([1]), msgpack.packb({1: 2}))
NONSENSE: dict[Query, tuple[dict[str, Any], str]] = {
    WRENCH_TARE: ({"duration": math.inf}, "duration"),
    WRENCH_IDENTIFY: ({"action": "dance"}, "start, add, solve"),
    TASK_COMMAND: ({"command": "dance"}, "wanted one of start, abort, release, reset"),
    SIM_COMMAND: ({"command": "dance"}, "wanted one of reset, load, push"),
    **dict.fromkeys(PARAMETER_QUERIES, ({"set": 3}, "wanted a map of names and values")),
}
"""A request that is none of the contract, and what the refusal says."""

every_service = pytest.mark.parametrize("subject", SERVICES, ids=repr)


@every_service
def test_it_is_alive_and_says_that_all_is_well_with_all_its_inputs(around: Surroundings) -> None:
    eventually(around.ok, PATIENCE, lambda: f"health ok: {around.words}")
    assert around.subject.process.known_as in around.bus.living()
    assert set(around.report.inputs) == {topic.key for topic in around.subject.inputs}


@every_service
def test_what_it_publishes_comes_at_the_stated_rate(around: Surroundings) -> None:
    slower, outputs = around.subject.slower, around.subject.outputs
    rates = {topic.key: slower.get(topic, topic.rate) for topic in outputs if topic.rate}
    eventually(lambda: all(around.heard[key] for key in rates), PATIENCE, "everything")
    before, turns = {key: len(around.heard[key]) for key in rates}, around.turns
    eventually(lambda: around.turns >= turns + 200, PATIENCE, "two seconds")
    duration = (around.turns - turns) * 0.01
    for key, rate in rates.items():
        count = len(around.heard[key]) - before[key]
        assert 0.6 * rate * duration - 1 <= count <= 2.2 * rate * duration, f"{key}: {count} in {duration} s"


@pytest.mark.parametrize(
    ("subject", "query"),
    [(subject, query) for subject in SERVICES for query in subject.queries],
    ids=lambda value: getattr(value, "key", None) or repr(value),
)
def test_nonsense_is_refused_in_one_line(around: Surroundings, query: Query) -> None:
    request, says = NONSENSE[query]
    for payload in (*NO_REQUEST, msgpack.packb(request)):
        answer = around.answer(query.key, payload)
        assert answer["ok"] is False
        assert 0 < len(answer["error"]) <= 600 and "\n" not in answer["error"], answer
    assert says in answer["error"]
    assert around.works(), around.words


@pytest.mark.parametrize("subject", [subject for subject in SERVICES if subject.parameter], ids=repr)
def test_parameters_are_told_taken_and_refused(around: Surroundings) -> None:
    assert around.subject.parameter is not None
    name, sound, wrong, says = around.subject.parameter
    (query,) = (query for query in PARAMETER_QUERIES if query.server == around.subject.name)
    table = around.client.ask(query)["parameters"]
    assert all(set(row) == {"value", "unit", "min", "max", "doc"} for row in table.values())
    before = table[name]["value"]
    with pytest.raises(Refused, match=says):
        around.client.ask(query, {"set": {name: wrong}})
    assert around.client.ask(query)["parameters"] == table
    try:
        assert around.client.ask(query, {"set": {name: sound}})["parameters"] == {
            **table,
            name: {**table[name], "value": sound},
        }
        eventually(lambda: around.subject.in_force(around), PATIENCE, f"{name} is in force")
    finally:
        around.client.ask(query, {"set": {name: before}})
