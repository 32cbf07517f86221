"""The dialect ``frames``, byte by byte (pure). All numbers are little-endian.

====== ====== ==============================================================================
offset size   what
====== ====== ==============================================================================
0      2      start: A5 5A
2      1      length N of the payload, 0 to 32
3      1      type, see below
4      2      sequence number, rises by one with each frame of this sender, wraps to 0
6      4      turn number; in frames of the robot the highest that it has seen
10     2      time-to-live in ms, 0 where the type has none
12     N      payload
12+N   2      CRC-16 of bytes 2 to 11+N: polynomial 1021, start FFFF, not reflected, no
              final xor ("CCITT-FALSE", "IBM-3740"; it is 29B1 for the text 123456789)
====== ====== ==============================================================================

From the server:

- 00 hello, no payload: the server has opened the line. Stand still and forget turn and sequence.
- 01 drive, ``int16 left, int16 right``: wheel speeds in mm/s, ahead positive. They are worth the
  time-to-live, counted from arrival; after it the robot stands still until the next drive.
- 02 axis, ``uint8 number, int16 position``: move an axis to position / 10000 of its range,
  -10000 to 10000. Its number is its place in the configuration's ``axes``, from 0.
- 03 stop, no payload: stand still now, whatever the turn.

The robot ignores drive and axis of a lower turn than it has seen, and within a turn those whose
sequence number is not newer than the last (a 16 bit difference of 1 to 32767).

From the robot, 2 to 50 times a second as it likes:

- 81 report, ``uint16 battery_mv, uint8 bumpers, int32 left, int32 right, uint8 flags,
  uint16 sequence``: battery voltage (0: not measured), pressed bumpers bit by bit, encoder ticks,
  flags (bit 0: a wheel turns; bit 1: stands because a time-to-live ran out), and the sequence
  number of the last frame that it took.

What has another type or length, or a wrong CRC, is ignored.
"""

from __future__ import annotations

import binascii
import struct
from dataclasses import dataclass
from typing import Final

START: Final = b"\xa5\x5a"
MAX_PAYLOAD: Final = 32
POSITION_SCALE: Final = 10_000

_HEADER: Final = struct.Struct("<2sBBHIH")
_CRC: Final = struct.Struct("<H")


@dataclass(frozen=True, slots=True)
class Hello:
    """The server has opened the line."""


@dataclass(frozen=True, slots=True)
class Drive:
    """Wheel speeds in mm/s, -32768 to 32767."""

    left_mmps: int
    right_mmps: int


@dataclass(frozen=True, slots=True)
class Axis:
    """Move axis `number` to `position` / 10000 of its range."""

    number: int
    position: int


@dataclass(frozen=True, slots=True)
class Stop:
    """Stand still now."""


@dataclass(frozen=True, slots=True)
class Report:
    """How the robot says it is."""

    battery_mv: int
    bumpers: int
    left_ticks: int
    right_ticks: int
    flags: int
    sequence: int

    @property
    def moving(self) -> bool:
        return bool(self.flags & 1)

    @property
    def timed_out(self) -> bool:
        return bool(self.flags & 2)


Body = Hello | Drive | Axis | Stop | Report


@dataclass(frozen=True, slots=True)
class Frame:
    """One frame; numbers that are too long for their field keep their lowest bits."""

    body: Body
    sequence: int = 0
    turn: int = 0
    ttl_ms: int = 0


_TYPES: Final[dict[int, tuple[type[Body], struct.Struct]]] = {
    0x00: (Hello, struct.Struct("<")),
    0x01: (Drive, struct.Struct("<hh")),
    0x02: (Axis, struct.Struct("<Bh")),
    0x03: (Stop, struct.Struct("<")),
    0x81: (Report, struct.Struct("<HBiiBH")),
}
_CODES: Final = {body: code for code, (body, _) in _TYPES.items()}


def encode(frame: Frame) -> bytes:
    """Give the bytes of a frame; raises `struct.error` if the body does not fit its fields."""
    code = _CODES[type(frame.body)]
    fields = [getattr(frame.body, name) for name in frame.body.__dataclass_fields__]
    payload = _TYPES[code][1].pack(*fields)
    header = _HEADER.pack(
        START,
        len(payload),
        code,
        frame.sequence & 0xFFFF,
        frame.turn & 0xFFFF_FFFF,
        frame.ttl_ms & 0xFFFF,
    )
    return header + payload + _crc(header[len(START) :] + payload)


class Decoder:
    """Finds frames in a stream of bytes; never raises, keeps at most one unfinished frame.

    After garbage it goes on with the next start that holds. `errors` counts what began like a
    frame and was none, or none that is known; `skipped_bytes` counts all that was in no frame.
    """

    def __init__(self) -> None:
        self._rest = b""
        self.errors = 0
        self.skipped_bytes = 0

    def feed(self, data: bytes) -> list[Frame]:
        """Take the next bytes; return the frames that are complete."""
        stream = self._rest + data
        frames: list[Frame] = []
        at = 0
        while True:
            start = _find_start(stream, at)
            self.skipped_bytes += start - at
            at = start
            if len(stream) - at < len(START) + 1:
                break
            length = stream[at + len(START)]
            if length > MAX_PAYLOAD:
                at = self._skip(at)
                continue
            end = at + _HEADER.size + length + _CRC.size
            if end > len(stream):
                break
            if _crc(stream[at + len(START) : end - _CRC.size]) != stream[end - _CRC.size : end]:
                at = self._skip(at)
                continue
            frame = _parse(stream[at:end])
            if frame is None:
                self.errors += 1
            else:
                frames.append(frame)
            at = end
        self._rest = stream[at:]
        return frames

    def _skip(self, at: int) -> int:
        self.errors += 1
        self.skipped_bytes += 1
        return at + 1


def _find_start(stream: bytes, at: int) -> int:
    """Give where the next start is or may be beginning, else the end."""
    start = stream.find(START, at)
    if start >= 0:
        return start
    return len(stream) - 1 if stream[at:].endswith(START[:1]) else len(stream)


def _parse(data: bytes) -> Frame | None:
    _, _, code, sequence, turn, ttl_ms = _HEADER.unpack_from(data)
    payload = data[_HEADER.size : -_CRC.size]
    body, layout = _TYPES.get(code, (None, None))
    if body is None or layout is None or layout.size != len(payload):
        return None
    return Frame(body(*layout.unpack(payload)), sequence=sequence, turn=turn, ttl_ms=ttl_ms)


def _crc(data: bytes) -> bytes:
    return _CRC.pack(binascii.crc_hqx(data, 0xFFFF))
