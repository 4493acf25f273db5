"""Queries and parameters of a service on the in-process bus."""

from __future__ import annotations

from typing import Any

import msgpack
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shared.parameters import Refused
from shared.requests import Nothing, Tare, Tared
from shared.schema.records import Record
from shared.topics import CONTROL_PARAMETERS, TASK_COMMAND, WRENCH_TARE, setup_topic
from shared.wire.bus import NoReply
from shared.wire.codec import encode_map
from tests.shared.loop.rig import Rig
from tests.shared.rig import ZERO
from tests.shared.strategies import any_plain

NESTED: list[Any] = []
for _ in range(1015):
    NESTED = [NESTED]


def test_a_query_is_answered_by_the_service() -> None:
    rig = Rig()
    asked: list[Record] = []
    rig.service.on_query = lambda request: asked.append(request) or Tared(ZERO, ZERO, 5, (0.0,) * 6)
    assert rig.stack.client.ask(WRENCH_TARE, {"duration": 2.0})["samples"] == 5
    rig.stack.client.ask(WRENCH_TARE)
    assert [type(request) for request in asked] == [Tare, Tare]
    assert [request.to_plain()["duration"] for request in asked] == [2.0, 1.0]


def test_what_a_service_works_by_is_told_with_each_request_and_every_second() -> None:
    rig = Rig(driver=0.02, required=())
    told: list[tuple[float, Record]] = []
    rig.stack.client.watch(setup_topic("recorder"), lambda heard: told.append((heard.header.stamp, heard.message)))
    rig.stack.run(2.5)
    rig.stack.client.ask(CONTROL_PARAMETERS, {"set": {"gain": 3.0}})
    asked = rig.stack.scheduler.clock.now_ns()
    rig.stack.run(4.0)
    assert [stamp for stamp, _ in told][:4] == [0, 1_000_000_000, 2_000_000_000, asked]
    assert [message.parameters["gain"] for _, message in told][:5] == [1.0, 1.0, 1.0, 3.0, 3.0]
    assert [(message.query, message.request) for _, message in told if message.query] == [
        (CONTROL_PARAMETERS.key, encode_map({"set": {"gain": 3.0}}))
    ]


@pytest.mark.parametrize("request_", [{"duration": 0}, {"duration": "long"}, {"duration": [1]}])
def test_a_request_that_is_not_as_declared_never_reaches_the_service(request_: dict[str, Any]) -> None:
    rig = Rig()
    with pytest.raises(Refused, match=r"duration .* wanted"):
        rig.stack.client.ask(WRENCH_TARE, request_)


def test_a_reply_that_is_not_as_declared_is_not_handed_on() -> None:
    rig = Rig()
    rig.service.on_query = lambda request: Nothing()
    with pytest.raises(Refused, match="wrench/tare answered with something else: force is missing"):
        rig.stack.client.ask(WRENCH_TARE)


def test_a_refusal_says_why() -> None:
    rig = Rig()
    rig.service.refuses = "not now"
    with pytest.raises(Refused, match=r"^not now$"):
        rig.stack.client.ask(WRENCH_TARE)


def test_nobody_answers_what_nobody_serves() -> None:
    with pytest.raises(NoReply, match="task/command"):
        Rig().stack.client.ask(TASK_COMMAND, {})


@pytest.mark.parametrize(
    "request_bytes",
    [
        b"\xc1",
        b"\x01",
        b"\x81",
        bytes(70_000),
        msgpack.packb({1: 2}),
        encode_map({"set": 3}),
        msgpack.packb({"set": {b"gain": 1.0}}),
        msgpack.packb({"set": {"gain": {b"a": 1}}}),
        encode_map({"set": {"gain": NESTED}}),
        encode_map({"set": {"x" * 20_000: 1.0}}),
        encode_map({"set": {"self": 1.0, "cls": 2, "": 3}}),
    ],
    ids=range(11),
)
def test_a_malformed_request_is_refused_and_ends_nothing(request_bytes: bytes) -> None:
    rig = Rig()
    reply = msgpack.unpackb(rig.stack.bus.query(CONTROL_PARAMETERS.key, request_bytes, 1.0))
    assert reply["ok"] is False
    assert 0 < len(reply["error"]) <= 600
    assert rig.service.parameters.gain == 1.0
    assert rig.stack.client.ask(CONTROL_PARAMETERS)["ok"]


@pytest.mark.parametrize("problem", [TypeError("x"), KeyError("duration"), ValueError("x"), AttributeError("x")])
def test_a_request_that_trips_the_service_is_refused_and_ends_nothing(problem: Exception) -> None:
    rig = Rig()

    def trip(_request: Record) -> Record:
        raise problem

    rig.service.on_query = trip
    with pytest.raises(Refused, match=type(problem).__name__):
        rig.stack.client.ask(WRENCH_TARE, {})
    rig.stack.run(0.2)


@settings(max_examples=60, deadline=None)
@given(wanted=any_plain)
def test_any_setting_is_granted_within_its_range_or_refused(wanted: object) -> None:
    rig = Rig()
    try:
        rig.stack.client.ask(CONTROL_PARAMETERS, {"set": {"gain": wanted}})
    except Refused:
        assert rig.service.parameters.gain == 1.0
    else:
        assert rig.service.parameters.gain == wanted and 0.0 <= rig.service.parameters.gain <= 10.0


def test_parameters_are_told_with_unit_range_and_meaning() -> None:
    reply = Rig().stack.client.ask(CONTROL_PARAMETERS)
    assert reply["parameters"] == {
        "gain": {"value": 1.0, "unit": "1/s", "min": 0.0, "max": 10.0, "doc": "a number"},
        "limit": {"value": [1.0, 1.0, 1.0], "unit": "N", "min": 0.1, "max": 50.0, "doc": "a vector"},
    }


def test_parameters_are_set_together_or_not_at_all() -> None:
    rig = Rig()
    with pytest.raises(Refused, match=r"limit is \[1.0, -3.0, 1.0\], allowed is 0.1 to 50 N"):
        rig.stack.client.ask(CONTROL_PARAMETERS, {"set": {"gain": 2.0, "limit": [1, -3, 1]}})
    assert rig.service.parameters.gain == 1.0
    reply = rig.stack.client.ask(CONTROL_PARAMETERS, {"set": {"gain": 2, "limit": [1, 3, 1]}})
    assert reply["parameters"]["limit"]["value"] == [1.0, 3.0, 1.0]
    assert rig.service.parameters.gain == 2.0


def test_a_flood_of_queries_does_not_keep_the_loop_from_stepping(rig: Rig) -> None:
    """However many requests arrive between two polls, a poll answers one, after the step."""
    answered: list[int] = []

    def flood() -> None:
        for _ in range(20):
            rig.stack.bus.query_later(WRENCH_TARE.key, b"", lambda reply: answered.append(len(rig.service.calls)))
        rig.stack.scheduler.at(rig.stack.scheduler.clock.now_ns() + 1_000_000, flood)

    flood()
    rig.stack.run(0.5)
    assert rig.service.calls == ["step"] * 50
    assert len(answered) > 500
    inbox = rig.runner._desk.inbox(WRENCH_TARE)
    replies: list[bytes] = []
    for _ in range(5):
        inbox(b"", replies.append)
    before = len(answered) + len(replies)
    rig.runner.poll()
    assert len(answered) + len(replies) - before <= 1


def test_more_requests_than_fit_are_refused_not_queued() -> None:
    rig = Rig()
    inbox = rig.runner._desk.inbox(WRENCH_TARE)
    replies: list[bytes] = []
    for _ in range(1000):
        inbox(b"", replies.append)
    assert len(replies) == 1000 - 32
    for refusal in map(msgpack.unpackb, replies):
        assert refusal == {"ok": False, "error": "wrench/tare: 32 requests are waiting already; ask again later"}
    rig.stack.run(1.0)
    assert [msgpack.unpackb(reply)["ok"] for reply in replies[1000 - 32 :]] == [True] * 32


@given(st.binary(max_size=100))
@settings(max_examples=50, deadline=None)
def test_any_request_bytes(request_bytes: bytes) -> None:
    rig = Rig()
    reply = msgpack.unpackb(rig.stack.bus.query(CONTROL_PARAMETERS.key, request_bytes, 1.0))
    assert isinstance(reply["ok"], bool)
