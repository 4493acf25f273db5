"""Messages to bytes and back: one MessagePack map each, header and fields side by side."""

from __future__ import annotations

from functools import cache
from typing import Any, TypeVar

import msgpack
import msgspec
import numpy as np

from shared.messages import Header
from shared.schema.fields import InvalidField
from shared.schema.records import Record
from shared.topics import MAP_CAP

_TEXT_ONLY = {str}
_MALFORMED = (ValueError, TypeError, OverflowError, RecursionError, msgspec.MsgspecError)
"""Errors of a decoder when a payload is not sound."""
_SMALL_MAP = 15
"""So many entries of a map are counted in its first byte."""

M = TypeVar("M", bound=Record)


class Payload(bytes):
    """A payload that knows what it was encoded from: within a process its readers need not decode it.

    They share the message, which was checked when it was built and which nobody can change.
    """

    content: tuple[Header, Record]

    @classmethod
    def of(cls, message: Record, header: Header) -> Payload:
        """The payload of a message."""
        payload = cls(encode(message, header))
        payload.content = header, message
        return payload


class Rejected(ValueError):
    """A payload is not a message of the contract; the text says why. It must be counted and never used."""


_encoder = msgspec.msgpack.Encoder(enc_hook=np.ndarray.tolist)


@cache
def _joint(message: type[Record]) -> tuple[bytes, int]:
    """Beginning of the map of header and message, and number of bytes that begin the map of the message alone."""
    count = len(message.kinds())
    both = count + len(Header.kinds())
    start = bytes((0x80 | both,)) if both <= _SMALL_MAP else b"\xde" + both.to_bytes(2, "big")
    return start, 1 if count <= _SMALL_MAP else 3


def encode(message: Record, header: Header) -> bytes:
    """The payload of a message."""
    start, cut = _joint(type(message))
    return start + _encoder.encode(header)[1:] + _encoder.encode(message)[cut:]


@cache
def _decoder(record: type[M]) -> msgspec.msgpack.Decoder[M]:
    return msgspec.msgpack.Decoder(record)


_header_decoder = _decoder(Header)


def decode(message_class: type[M], payload: bytes, cap: int = MAP_CAP) -> tuple[Header, M]:
    """Header and message of a payload.

    Raises:
        Rejected: too large, no MessagePack map, a field missing, of wrong type or shape, or not finite.
    """
    if len(payload) > cap:
        raise Rejected(_too_large(payload, cap))
    if isinstance(payload, Payload):
        header, message = payload.content
        if isinstance(message, message_class):
            return header, message
    try:
        header, message = _header_decoder.decode(payload), _decoder(message_class).decode(payload)
        header.settle(decoded=True)
        message.settle(decoded=True)
        return header, message
    except InvalidField as problem:
        raise Rejected(str(problem)) from None
    except _MALFORMED:
        data = decode_map(payload, cap)
    try:
        # Once more, now to say what is wrong with it.
        return Header.from_plain(data), message_class.from_plain(data)
    except InvalidField as problem:
        raise Rejected(str(problem)) from None


def encode_map(data: dict[str, Any]) -> bytes:
    """The payload of a query's request or reply."""
    return msgpack.packb(data)


def decode_map(payload: bytes, cap: int = MAP_CAP) -> dict[str, Any]:
    """A MessagePack map with text keys.

    Raises:
        Rejected: too large, not MessagePack, or not such a map.
    """
    if len(payload) > cap:
        raise Rejected(_too_large(payload, cap))
    try:
        data = msgpack.unpackb(payload)
    except (ValueError, msgpack.exceptions.UnpackException, OverflowError, RecursionError, TypeError) as problem:
        raise Rejected(f"not MessagePack ({type(problem).__name__})") from None
    if not isinstance(data, dict) or not set(map(type, data)) <= _TEXT_ONLY:
        raise Rejected(f"{type(data).__name__}, wanted a map with text keys")
    return data


def _too_large(payload: bytes, cap: int) -> str:
    return f"{len(payload)} bytes, at most {cap} are allowed"
