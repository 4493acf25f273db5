"""The size of a JPEG image, read from its header: what is too large is not decoded first to find that out."""

from __future__ import annotations

_FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
"""Markers of the segment that has the size; the three others define tables."""
_WITHOUT_LENGTH = frozenset((0x01, *range(0xD0, 0xD9)))
_FILL, _START, _SCAN = 0xFF, b"\xff\xd8", 0xDA


def size(data: bytes) -> tuple[int, int] | None:
    """Width and height [px]; None if this is no JPEG image."""
    if not data.startswith(_START):
        return None
    at = len(_START)
    while at + 9 <= len(data) and data[at] == _FILL:
        marker = data[at + 1]
        if marker in _FRAMES:
            return int.from_bytes(data[at + 7 : at + 9], "big"), int.from_bytes(data[at + 5 : at + 7], "big")
        if marker == _SCAN:
            return None
        if marker == _FILL:
            at += 1
        elif marker in _WITHOUT_LENGTH:
            at += 2
        else:
            at += 2 + int.from_bytes(data[at + 2 : at + 4], "big")
    return None
