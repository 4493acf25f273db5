"""Size and depth of a compressed picture by its first bytes: nothing is decoded to find out that it is too large."""

from __future__ import annotations

_JPEG_START, _FILL, _SCAN = b"\xff\xd8", 0xFF, 0xDA
_FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}  # have the size; the three others define tables
_WITHOUT_LENGTH = frozenset((0x01, *range(0xD0, 0xD9)))
_PNG_START = b"\x89PNG\r\n\x1a\n\x00\x00\x00\x0dIHDR"

Header = tuple[int, int, int]
"""Width and height [px], and bits of each channel."""


def png_header(data: bytes) -> Header | None:
    """What a PNG image's header says, None if this is none."""
    if not data.startswith(_PNG_START) or len(data) < 25:
        return None
    return _number(data[16:20]), _number(data[20:24]), data[24]


def jpeg_header(data: bytes) -> Header | None:
    """What a JPEG image's header says, None if this is none."""
    if not data.startswith(_JPEG_START):
        return None
    at = len(_JPEG_START)
    while at + 9 <= len(data) and data[at] == _FILL:
        marker = data[at + 1]
        if marker in _FRAMES:
            return _number(data[at + 7 : at + 9]), _number(data[at + 5 : at + 7]), data[at + 4]
        if marker == _SCAN:
            return None
        if marker == _FILL:
            at += 1
        elif marker in _WITHOUT_LENGTH:
            at += 2
        else:
            at += 2 + _number(data[at + 2 : at + 4])
    return None


def _number(data: bytes) -> int:
    return int.from_bytes(data, "big")
