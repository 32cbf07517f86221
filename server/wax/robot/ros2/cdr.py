"""Decodes CDR, the encoding of DDS, without copying long members (pure)."""

from __future__ import annotations

import struct

_ENCAPSULATION_BYTES = 4
_PLAIN_CDR = (0, 1)
"""Big and little endian; ROS 2 sends nothing else."""


class CdrReader:
    """Decodes one member after the other; raises `ValueError` for truncated or non-CDR data."""

    def __init__(self, data: bytes) -> None:
        self._data = memoryview(data)
        if len(data) < _ENCAPSULATION_BYTES or data[0] != 0 or data[1] not in _PLAIN_CDR:
            raise ValueError("this is not plain CDR")
        self._order = "<" if data[1] else ">"
        self._at = _ENCAPSULATION_BYTES

    def int32(self) -> int:
        return self._number("i", 4)

    def uint32(self) -> int:
        return self._number("I", 4)

    def uint8(self) -> int:
        return self._number("B", 1)

    def string(self) -> str:
        """Decode a string; its length includes the terminating zero."""
        return bytes(self._take(self.uint32())).rstrip(b"\0").decode(errors="replace")

    def octets(self) -> memoryview:
        """Decode a sequence of octets without copying it."""
        return self._take(self.uint32())

    def _number(self, code: str, size: int) -> int:
        at = self._at - _ENCAPSULATION_BYTES
        self._at += -at % size
        (number,) = struct.unpack(self._order + code, self._take(size))
        return int(number)

    def _take(self, count: int) -> memoryview:
        taken = self._data[self._at : self._at + count]
        if len(taken) < count:
            raise ValueError("the message is cut off")
        self._at += count
        return taken
