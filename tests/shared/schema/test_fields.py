"""What each kind of field admits, alike when a message is built and when it is decoded."""

from __future__ import annotations

import math

import msgpack
import numpy as np
import pytest

from shared.messages import FtSample, Header, JointState, Stop, TaskStatus, TwistCommand
from shared.schema.fields import Boolean, Integer, InvalidField
from shared.wire.codec import decode
from tests.shared.samples import HEADER, SAMPLE, rejection


def test_integers_pass_for_floats_and_nothing_else_does() -> None:
    _, sample = decode(FtSample, msgpack.packb(SAMPLE | {"force": [1, -2, 3]}))
    assert sample.force.dtype == np.float64 and sample.force.tolist() == [1.0, -2.0, 3.0]
    for wrong in (True, None, "1.0", b"1", [1.0], {}):
        rejection(FtSample, SAMPLE | {"force": [1.0, 2.0, wrong]})
        rejection(TwistCommand, HEADER | {"linear": [0.0] * 3, "angular": [0.0] * 3, "ttl": wrong})


def test_a_text_as_long_as_a_message_is_cut_and_no_reason_to_refuse_it() -> None:
    long = {"engaged": True, "reason": "x" * 60_000}
    for stop in (decode(Stop, msgpack.packb(HEADER | long))[1], Stop(**long)):
        assert stop.engaged and stop.reason == "x" * 200
    # Who retells it in a text of his own is short enough to be heard himself.
    assert len(TaskStatus("holding", 0.0, "x" * 60_000, 0.0, 0.0, None).reason) == 2000


@pytest.mark.parametrize("wrong", [True, 1.0, "1", None, -1, [1]])
def test_a_sequence_number_is_a_natural_number(wrong: object) -> None:
    assert "seq" in rejection(FtSample, SAMPLE | {"seq": wrong})


@pytest.mark.parametrize("wrong", [0, 1, "true", None, 1.0])
def test_only_booleans_are_booleans(wrong: object) -> None:
    assert "valid" in rejection(FtSample, SAMPLE | {"valid": wrong})
    assert "saturated" in rejection(FtSample, SAMPLE | {"saturated": wrong})


@pytest.mark.parametrize("session", [0, -(2**63), 2**63 - 1, 2**64 - 1])
def test_a_session_may_be_any_integer_of_64_bits(session: int) -> None:
    header, _ = decode(FtSample, msgpack.packb(SAMPLE | {"session": session}))
    assert header.session == session


@pytest.mark.parametrize("length", [0, 2, 4, 7_000])
def test_vectors_of_the_wrong_length_are_rejected(length: int) -> None:
    assert f"force has {length} elements, wanted 3" in rejection(FtSample, SAMPLE | {"force": [0.0] * length})


def test_finite_numbers_whose_sum_overflows_are_accepted() -> None:
    _, sample = decode(FtSample, msgpack.packb(SAMPLE | {"force": [1.7e308, 1.7e308, -1e308]}))
    assert sample.force.tolist() == [1.7e308, 1.7e308, -1e308]


def test_infinities_that_cancel_are_rejected() -> None:
    rejection(FtSample, SAMPLE | {"force": [math.inf, -math.inf, 0.0]})


@pytest.mark.parametrize("scale", [0.0, 0.998, 1.002, 1e300])
def test_a_quaternion_has_unit_norm(scale: float) -> None:
    assert "orientation" in rejection(FtSample, SAMPLE | {"orientation": [0.0, scale, 0.0, 0.0]})


def test_a_quaternion_off_by_rounding_is_normalised() -> None:
    _, sample = decode(FtSample, msgpack.packb(SAMPLE | {"orientation": [0.0, 1.0005, 0.0, 0.0]}))
    assert np.linalg.norm(sample.orientation) == pytest.approx(1.0, abs=1e-15)


def test_joint_vectors_belong_to_the_names() -> None:
    joints = HEADER | {"name": ["a", "b"], "position": [0.0] * 2, "velocity": [0.0] * 2, "effort": [0.0]}
    assert "effort has 1 elements" in rejection(JointState, joints)
    with pytest.raises(InvalidField, match="velocity"):
        JointState(name=["a"], position=[0.0], velocity=[], effort=[0.0])


def test_nested_fields_are_named_with_their_path() -> None:
    marker = {"position": [0.0] * 3, "orientation": [0.0, 0.0, 0.0, 1.0]}
    status = {"state": "", "since": 0.0, "reason": "", "rotation": 0.0, "height": 0.0, "marker": marker}
    assert "marker.age is missing" in rejection(TaskStatus, HEADER | status)


def test_messages_cannot_be_altered_through_their_arrays() -> None:
    force = np.array([1.0, 2.0, 3.0])
    sample = FtSample(force, [0.0] * 3, [0.0, 0.0, 0.0, 1.0], [0.0] * 3, False)
    force[0] = 99.0
    assert sample.force[0] == 1.0
    for array in (sample.force, sample.orientation):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0


def test_building_checks_as_decoding_does() -> None:
    with pytest.raises(InvalidField, match="force has shape"):
        FtSample(np.zeros((3, 1)), [0.0] * 3, [0.0, 0.0, 0.0, 1.0], [0.0] * 3, False)
    with pytest.raises(InvalidField, match="ttl"):
        TwistCommand([0.0] * 3, [0.0] * 3, ttl=0.0)
    with pytest.raises(InvalidField, match="wanted true or false"):
        Stop(1)  # type: ignore[arg-type]


def test_kinds_of_integers_and_booleans_accept_numpy() -> None:
    assert Integer().check(np.int64(3), "seq") == 3
    assert Boolean().check(np.bool_(True), "valid") is True
    with pytest.raises(InvalidField):
        Integer().check(np.float64(3.0), "seq")
    assert Header(np.int64(1), 2, 3, np.True_).to_plain() == {"seq": 1, "session": 2, "stamp": 3, "valid": True}
