"""Messages to bytes and back: one MessagePack map each, header and fields side by side."""

from __future__ import annotations

from typing import Any, TypeVar

import msgpack

from shared.messages import Header
from shared.schema.fields import InvalidField
from shared.schema.records import Record

MAP_CAP = 64 * 1024
"""Largest payload [bytes] of a query, and of every message that is not an image."""

_TEXT_ONLY = {str}

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


def encode(message: Record, header: Header) -> bytes:
    """The payload of a message."""
    return msgpack.packb(header.to_plain() | message.to_plain())


def decode(message_class: type[M], payload: bytes, cap: int = MAP_CAP) -> tuple[Header, M]:
    """Header and message of a payload.

    Raises:
        Rejected: too large, no MessagePack map, a field missing, of wrong type or shape, or not finite.
    """
    if isinstance(payload, Payload) and len(payload) <= cap:
        header, message = payload.content
        if isinstance(message, message_class):
            return header, message
    data = decode_map(payload, cap)
    try:
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
        raise Rejected(f"{len(payload)} bytes, at most {cap} are allowed")
    try:
        data = msgpack.unpackb(payload)
    except (ValueError, msgpack.exceptions.UnpackException, OverflowError, TypeError) as problem:
        raise Rejected(f"not MessagePack ({type(problem).__name__})") from None
    if not isinstance(data, dict) or not set(map(type, data)) <= _TEXT_ONLY:
        raise Rejected(f"{type(data).__name__}, wanted a map with text keys")
    return data
