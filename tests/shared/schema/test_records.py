"""Records are declared in full, or not at all: what a declaration cannot mean is refused where it stands."""

from __future__ import annotations

from typing import Any

import msgspec
import numpy as np
import pytest

from shared.messages import Enable, Header, JointState
from shared.requests import ParameterRequest
from shared.schema.fields import InvalidField, Number, Text, Vector
from shared.schema.records import Record, of
from shared.topics import TOPICS
from shared.wire.codec import decode, encode


class Bounded(Record):
    number: float = of(Number(above=0.0, minimum=1.0, maximum=2.0), default=1)
    vector: np.ndarray = of(Vector(size=2, minimum=-1.0, maximum=1.0), default=(0, 1))


HEADER = Header(0, 1, 2, True)


def payload(**fields: Any) -> bytes:
    return msgspec.msgpack.encode({"seq": 0, "session": 1, "stamp": 2, "valid": True, **fields})


@pytest.mark.parametrize("fields", [{"number": 0.5}, {"number": 2.5}, {"vector": [0.0, 1.5]}, {"vector": [-2.0, 0.0]}])
def test_a_bound_holds_alike_for_what_is_built_and_for_what_is_decoded(fields: dict[str, Any]) -> None:
    (name,) = fields
    with pytest.raises(InvalidField, match=name):
        Bounded(**fields)
    with pytest.raises(ValueError, match=name):
        decode(Bounded, payload(**fields))


def test_a_default_is_of_its_kind() -> None:
    _, message = decode(Bounded, payload())
    assert type(message.number) is float and message.vector.dtype == np.float64
    with pytest.raises(InvalidField, match="word is 'c', wanted one of a, b"):

        class Wrong(Record):
            word: str = of(Text(choices=("a", "b")), default="c")


def test_a_record_has_its_own_fields_only_and_each_is_declared() -> None:
    with pytest.raises(TypeError, match="own fields only"):

        class More(Enable):
            extra: float = of(Number())

    with pytest.raises(TypeError, match=r"Stray\.extra: a field of a record is declared by of"):

        class Stray(Record):
            extra: int = 3


def test_no_message_has_a_field_of_the_header() -> None:
    header = {name for name, *_ in Header.kinds()}
    assert all(header.isdisjoint(name for name, *_ in topic.message.kinds()) for topic in TOPICS)


def test_a_message_shares_nothing_with_what_it_was_built_of() -> None:
    force, asked = np.zeros(2), {"gain": 1.0}
    built, request = Bounded(vector=force), ParameterRequest(asked)
    force[0], asked["more"] = 1.0, 2.0
    assert not built.vector.any() and request.set == {"gain": 1.0}
    with pytest.raises(ValueError, match="read-only"):
        built.vector[0] = 1.0
    with pytest.raises(AttributeError):
        built.number = 2.0  # type: ignore[misc]


def test_numpy_s_texts_travel_as_texts() -> None:
    names = [np.str_("one")]
    assert decode(JointState, encode(JointState(names, [0.0], [0.0], [0.0]), HEADER))[1].name == ("one",)
