"""Checks the counts in an MP4 file before FFmpeg allocates memory for them.

A file of three kilobytes can otherwise cost FFmpeg gigabytes and seconds (boxes: ISO/IEC 14496-12,
4.2 and 8.6 to 8.8).
"""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, BinaryIO, Final

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

_HOLD_BOXES: Final = frozenset(
    (b"moov", b"trak", b"edts", b"mdia", b"minf", b"stbl", b"mvex", b"moof", b"traf", b"udta")
)
_COUNTED: Final = {b"trun": 4, b"stts": 4, b"ctts": 4, b"stsc": 4, b"stco": 4, b"stsz": 8}
"""The offset of these boxes' count in bytes after the header."""


def is_believable(path: Path) -> bool:
    """Return whether no box counts more samples than the file has bytes; True if it is not MP4.

    Raises `OSError`.
    """
    size = path.stat().st_size
    with path.open("rb") as file:
        return all(count <= size for count in _counts(file, size))


def _counts(file: BinaryIO, size: int) -> Iterator[int]:
    insides = [(0, size)]
    while insides:
        at, end = insides.pop()
        while at + 8 <= end:
            file.seek(at)
            head = file.read(16).ljust(16, b"\0")
            length, kind, long = struct.unpack("!I4sQ", head)
            begin = at + 8
            if length == 1:
                length, begin = long, at + 16
            if length < begin - at:  # 0 means to the end; anything else is invalid
                length = end - at
            at = min(end, at + length)
            if kind in _HOLD_BOXES:
                insides.append((begin, at))
            elif kind in _COUNTED:
                file.seek(begin + _COUNTED[kind])
                yield int.from_bytes(file.read(4))
