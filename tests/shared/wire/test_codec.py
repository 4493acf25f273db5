"""Whatever arrives is either a whole, finite message of the contract or rejected: no third way, no exception."""

from __future__ import annotations

import math
from dataclasses import MISSING
from typing import Any

import msgpack
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from shared.messages import (
    BaseTwistCommand,
    ControlTarget,
    ExternalWrench,
    FtSample,
    GripperState,
    Header,
    TwistCommand,
)
from shared.schema.fields import InvalidField, Kind, Number, Vector
from shared.schema.records import MapOf, Nullable, Record, RecordOf
from shared.sim_messages import BagState
from shared.topics import MAP_CAP
from shared.wire.codec import Payload, Rejected, decode, decode_map, encode, encode_map
from tests.shared.samples import SAMPLE, rejection
from tests.shared.strategies import MESSAGES, any_plain, payload_map

every_message = pytest.mark.parametrize("message", MESSAGES, ids=lambda message: message.__name__)
few = settings(max_examples=10, deadline=None, suppress_health_check=[HealthCheck.too_slow])
many = settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.too_slow])


def all_finite(value: object) -> bool:
    match value:
        case float():
            return math.isfinite(value)
        case list() | tuple():
            return all(all_finite(element) for element in value)
        case dict():
            return all(all_finite(element) for element in value.values())
    return True


@every_message
@few
@given(data=st.data())
def test_round_trip(message: type[Record], data: st.DataObject) -> None:
    sent = data.draw(payload_map(message))
    header, received = decode(message, msgpack.packb(sent))
    again = msgpack.unpackb(encode(received, header))
    assert again.keys() == sent.keys()
    for name, value in sent.items():
        if isinstance(value, list) and value and isinstance(value[0], float):
            np.testing.assert_allclose(again[name], value, rtol=1e-12)
        elif not isinstance(value, dict):  # nested quaternions are normalised
            assert again[name] == value


@pytest.mark.parametrize("message", [FtSample, ControlTarget, ExternalWrench], ids=lambda one: one.__name__)
@many
@given(data=st.data())
def test_fields_are_judged_together_as_each_alone(message: type[Record], data: st.DataObject) -> None:
    sent = data.draw(payload_map(message))
    name = data.draw(st.sampled_from([name for name, _, _ in message.kinds()]))
    sent[name] = data.draw(st.just(sent[name]) | any_plain | st.lists(st.floats(), min_size=3, max_size=6))
    kind = {name: kind for name, kind, _ in message.kinds()}[name]
    try:
        alone = kind.check(sent[name], name)
    except InvalidField as problem:
        assert rejection(message, sent) == str(problem)
        return
    _, received = decode(message, msgpack.packb(sent))
    np.testing.assert_array_equal(getattr(received, name), alone)


@every_message
@few
@given(data=st.data())
def test_unknown_fields_are_ignored(message: type[Record], data: st.DataObject) -> None:
    decode(message, msgpack.packb(data.draw(payload_map(message)) | {"a field of version 2": [None]}))


@every_message
@few
@given(data=st.data())
def test_a_missing_field_is_named(message: type[Record], data: st.DataObject) -> None:
    sent = data.draw(payload_map(message))
    optional = {name for name, _, default in message.kinds() if default is not MISSING}
    name = data.draw(st.sampled_from(sorted(sent.keys() - optional)))
    del sent[name]
    assert name in rejection(message, sent)


def test_only_the_fields_to_which_the_contract_gives_a_default_may_be_missing() -> None:
    optional = {
        f"{message.__name__}.{name}"
        for message in MESSAGES
        for name, _, default in message.kinds()
        if default is not MISSING
    }
    assert optional == {
        "RobotStatus.held",  # a robot whose gate does not count
        "RobotStatus.require_enable",  # a robot without an enabling device
        "TwistCommand.ttl",
        "BaseTwistCommand.ttl",
        "ControlTarget.nominal_force",
        "ControlTarget.nominal_torque",
        "Stop.reason",  # a stop without a reason is still a stop
        "FtSample.gravity",
        "CameraImage.distortion_model",
        "ExternalWrench.zero_age",
        "ControlStatus.limit",
        "ControlStatus.nominal",
        "Health.links",
    }


def test_a_command_without_a_ttl_has_that_of_the_contract() -> None:
    header = {"seq": 0, "session": 1, "stamp": 0, "valid": True}
    for message, fields, ttl in (
        (TwistCommand, {"linear": [0.1, 0.0, 0.0], "angular": [0.0] * 3}, 0.05),
        (BaseTwistCommand, {"velocity": [0.1, 0.0, 0.0]}, 0.1),
    ):
        assert decode(message, encode_map(header | fields))[1].ttl == ttl


def _number_paths(record: type[Record], path: tuple[str, ...] = ()) -> list[tuple[tuple[str, ...], Kind]]:
    found: list[tuple[tuple[str, ...], Kind]] = []
    for name, declared, _ in record.kinds():
        kind = declared.kind if isinstance(declared, (MapOf, Nullable)) else declared
        if isinstance(kind, (Number, Vector)):
            found.append(((*path, name), kind))
        elif isinstance(kind, RecordOf):
            assert kind.record is not None
            found += _number_paths(kind.record, (*path, name))
    return found


@every_message
@few
@given(data=st.data())
def test_no_non_finite_number_enters_by_any_field(message: type[Record], data: st.DataObject) -> None:
    sent = data.draw(payload_map(message))
    bad = data.draw(st.sampled_from((math.nan, math.inf, -math.inf)))
    for path, kind in _number_paths(message):
        *parents, name = path
        holder: Any = sent
        for parent in parents:
            holder = holder[parent]
            if holder and all(isinstance(inner, dict) for inner in holder.values()):
                holder = next(iter(holder.values()))
        if not holder or (isinstance(kind, Vector) and not holder[name]):
            continue  # this example has no such record or element
        kept = holder[name]
        if isinstance(kind, Vector):
            holder[name] = list(kept)
            holder[name][data.draw(st.integers(0, len(kept) - 1))] = bad
        else:
            holder[name] = bad
        assert name in rejection(message, sent)
        holder[name] = kept


@many
@given(message=st.sampled_from(MESSAGES), data=st.data())
def test_any_value_in_any_field_is_finite_or_rejected(message: type[Record], data: st.DataObject) -> None:
    sent = data.draw(payload_map(message))
    name = data.draw(st.sampled_from(sorted(sent)))
    sent[name] = data.draw(any_plain)
    try:
        header, received = decode(message, msgpack.packb(sent))
    except Rejected:
        return
    assert all_finite(header.to_plain() | received.to_plain())


@many
@given(message=st.sampled_from(MESSAGES), payload=st.binary(max_size=300))
def test_any_bytes_are_rejected(message: type[Record], payload: bytes) -> None:
    with pytest.raises(Rejected):
        decode(message, payload)


@many
@given(data=st.data())
def test_flipped_and_cut_bytes(data: st.DataObject) -> None:
    payload = bytearray(msgpack.packb(SAMPLE))
    for _ in range(data.draw(st.integers(1, 4))):
        payload[data.draw(st.integers(0, len(payload) - 1))] = data.draw(st.integers(0, 255))
    cut = bytes(payload[: data.draw(st.integers(0, len(payload)))])
    try:
        header, received = decode(FtSample, cut)
    except Rejected:
        return
    assert all_finite(header.to_plain() | received.to_plain())


@few
@given(message=st.sampled_from(MESSAGES), data=any_plain)
def test_what_is_no_map_with_text_keys_is_rejected(message: type[Record], data: object) -> None:
    rejection(message, data)
    rejection(message, {b"seq": 1})


@pytest.mark.parametrize("field", ["seq", "session", "stamp", "valid", "force", "saturated", "unknown"])
@pytest.mark.parametrize("depth", [10, 990, 1020, 60_000])
def test_deep_nesting(field: str, depth: int) -> None:
    nested = b"\x91" * depth + b"\x01"
    rest = {name: value for name, value in SAMPLE.items() if name != field}
    payload = bytes([0x80 + len(rest) + 1]) + b"".join(
        msgpack.packb(name) + msgpack.packb(value) for name, value in rest.items()
    )
    payload += msgpack.packb(field) + nested
    if field == "unknown" and depth < 2000:
        decode(FtSample, payload)
    else:
        with pytest.raises(Rejected):
            decode(FtSample, payload)


@pytest.mark.parametrize("size", [MAP_CAP + 1, 1_000_000])
def test_oversized_payloads_are_rejected_unread(size: int) -> None:
    padded = msgpack.packb(SAMPLE | {"padding": bytes(size)})
    with pytest.raises(Rejected, match=f"{len(padded)} bytes, at most {MAP_CAP}"):
        decode(FtSample, padded)
    fitting = msgpack.packb(SAMPLE | {"padding": bytes(MAP_CAP - 400)})
    assert len(fitting) <= MAP_CAP
    decode(FtSample, fitting)


def test_length_claims_beyond_the_payload_are_rejected() -> None:
    for claim in (b"\xdf\xff\xff\xff\xff", b"\xdd\xff\xff\xff\xff", b"\xc6\xff\xff\xff\xff", b"\xdb\x7f\xff\xff\xff"):
        with pytest.raises(Rejected):
            decode(FtSample, claim)


@few
@given(st.dictionaries(st.text(st.characters(exclude_categories=("Cs",))), any_plain, max_size=5))
def test_requests_and_replies_survive(data: dict[str, Any]) -> None:
    assert repr(decode_map(encode_map(data))) == repr(data)


def test_within_a_process_readers_share_the_message_that_was_encoded() -> None:
    header, message = Header(1, 2, 3, True), BagState(1.0, 0.5)
    payload = Payload.of(message, header)
    assert decode(BagState, payload) == (header, message)
    assert decode(BagState, bytes(payload))[1].height == 0.5


def test_a_payload_that_carries_another_message_or_is_too_long_is_refused_as_ever() -> None:
    payload = Payload.of(BagState(1.0, 0.5), Header(1, 2, 3, True))
    with pytest.raises(Rejected, match="missing"):
        decode(GripperState, payload)
    with pytest.raises(Rejected, match="at most 10"):
        decode(BagState, payload, cap=10)


@pytest.mark.parametrize("gravity", [(0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 0.8, -0.6)])
def test_gravity_points_where_things_fall(gravity: tuple[float, float, float]) -> None:
    """An accelerometer at rest tells the opposite, and a sensor its own axes."""
    level = (0.0, 0.0, 0.0, 1.0)
    if gravity[2] < -0.5:
        assert FtSample((0.0,) * 3, (0.0,) * 3, level, (0.0,) * 3, False, gravity).gravity[2] == -0.6
    else:
        with pytest.raises(InvalidField, match="where things fall, in base axes"):
            FtSample((0.0,) * 3, (0.0,) * 3, level, (0.0,) * 3, False, gravity)
